#include "client/smoothing_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "tests/client/fake_server.h"
#include "tests/client/temporary_folder.h"

namespace burnish::client {
namespace {

using namespace std::chrono_literals;
using cli::TemporaryFolder;

const CallOptions kOnce{.retry = {.attempts = 1}};

v1::SmoothRequest request_with(const std::string& mesh) {
  v1::SmoothRequest request;
  request.set_mesh(mesh);
  request.mutable_options()->set_method("taubin");
  return request;
}

v1::CompareRequest comparison_of(const std::string& reference, const std::string& mesh) {
  v1::CompareRequest request;
  request.set_reference(reference);
  request.set_mesh(mesh);
  return request;
}

TEST(SmoothingClient, ReturnsTheReply) {
  const FakeServer server({.smooth = echo});
  const auto reply = SmoothingClient(server.address()).smooth(request_with("v 0 0 0"));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh(), "v 0 0 0");
  EXPECT_EQ(reply->report().method(), "taubin");
}

TEST(SmoothingClient, Compares) {
  const FakeServer server({.compare = [](const v1::CompareRequest& request, v1::CompareResponse& response) {
    response.mutable_errors()->set_against(request.reference() + "/" + request.mesh());
    return grpc::Status::OK;
  }});
  const auto reply = SmoothingClient(server.address()).compare(comparison_of("right", "wrong"));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->errors().against(), "right/wrong");
}

TEST(SmoothingClient, ListsTheMethods) {
  const FakeServer server({});
  const auto reply = SmoothingClient(server.address()).list_methods();
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->methods(0).name(), "adaptive");
}

TEST(SmoothingClient, CarriesMessagesBeyondFourMegabytes) {
  const FakeServer server({.smooth = echo});
  const std::string mesh(6 << 20, 'x');
  const auto reply =
      SmoothingClient(server.address()).smooth(request_with(mesh), {.unary_bytes = std::size_t{8} << 20});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh().size(), mesh.size());
}

TEST(SmoothingClient, TalksThroughAUnixDomainSocket) {
  const TemporaryFolder folder;
  const std::string address = "unix:" + (folder / "socket");
  const FakeServer server({.smooth = echo}, address);
  const auto reply = SmoothingClient(address).smooth(request_with("v 0 0 0"));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh(), "v 0 0 0");
}

TEST(SmoothingClient, CompressesWhenAsked) {
  const CallOptions gzip{.compression = Compression::Gzip};
  const FakeServer server({.smooth = echo, .smooth_stream = echo_stream});
  const std::string mesh(3 << 20, 'x');
  for (const std::size_t unary_bytes : {std::size_t{0}, std::size_t{4} << 20}) {
    CallOptions options = gzip;
    options.unary_bytes = unary_bytes;
    const auto reply = SmoothingClient(server.address()).smooth(request_with(mesh), options);
    ASSERT_TRUE(reply.ok()) << reply.error().message;
    EXPECT_EQ(reply->mesh(), mesh);
  }
  const FakeServer plain({.smooth = echo}, "127.0.0.1:0", false);
  EXPECT_TRUE(SmoothingClient(plain.address()).smooth(request_with(mesh)).ok());
  const auto refused = SmoothingClient(plain.address()).smooth(request_with(mesh), gzip);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("gzip"));
}

TEST(SmoothingClient, NamesTheServersCauseAndField) {
  const FakeServer server({.smooth = [](auto&, auto&, auto&) {
    return refusal(grpc::StatusCode::INVALID_ARGUMENT, "BAD_OPTION", "lambda");
  }});
  const auto reply = SmoothingClient(server.address()).smooth({});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reply.error().cause, "bad_option");
  EXPECT_EQ(reply.error().message, "the server says why");
  EXPECT_EQ(reply.error().field, "lambda");
  EXPECT_EQ(reply.error().attempts, 1);
}

struct PlainStatus {
  grpc::StatusCode code;
  const char* details;
  const char* cause;
};

TEST(SmoothingClient, FindsACauseForStatusesWithoutOne) {
  const PlainStatus rows[] = {
      {grpc::StatusCode::UNAVAILABLE, "", "unreachable"},
      {grpc::StatusCode::RESOURCE_EXHAUSTED, "", "too_large"},
      {grpc::StatusCode::UNIMPLEMENTED, "", "internal"},
      {grpc::StatusCode::INTERNAL, "\xff\xff not a message", "internal"},
  };
  for (const PlainStatus& row : rows) {
    const FakeServer server(
        {.smooth = [&row](auto&, auto&, auto&) { return grpc::Status(row.code, "why", row.details); }});
    const auto reply = SmoothingClient(server.address()).smooth({}, kOnce);
    ASSERT_FALSE(reply.ok()) << row.cause;
    EXPECT_EQ(reply.error().code, row.code) << row.cause;
    EXPECT_EQ(reply.error().cause, row.cause);
  }
}

TEST(SmoothingClient, KeepsItsDeadline) {
  const FakeServer server({.smooth = [](auto& context, auto&, auto&) { return until_cancelled(context); },
                           .smooth_stream = [](auto& context, auto&) { return until_cancelled(context); }});
  for (const std::size_t unary_bytes : {0, 1000}) {
    const auto reply = SmoothingClient(server.address())
                           .smooth(request_with("mesh"), {.timeout = 50ms, .unary_bytes = unary_bytes});
    ASSERT_FALSE(reply.ok());
    EXPECT_EQ(reply.error().cause, "deadline_exceeded");
    EXPECT_EQ(reply.error().attempts, 1);
  }
}

TEST(SmoothingClient, StopsFromAnotherThread) {
  std::promise<void> arrived_in_one, arrived_by_stream;
  const auto arrive_and_wait = [](std::promise<void>& arrived, grpc::ServerContext& context) {
    arrived.set_value();
    return until_cancelled(context);
  };
  const FakeServer server(
      {.smooth = [&](auto& context, auto&, auto&) { return arrive_and_wait(arrived_in_one, context); },
       // Reads nothing: the upload stands still when the stop comes.
       .smooth_stream = [&](auto& context, auto&) { return arrive_and_wait(arrived_by_stream, context); }});
  const SmoothingClient client(server.address());
  const v1::SmoothRequest request = request_with(std::string(16 << 20, 'x'));
  for (const bool by_stream : {true, false}) {
    const std::size_t unary_bytes = by_stream ? 0 : 32 << 20;
    std::stop_source stop;
    auto reply = std::async(std::launch::async, [&] {
      return client.smooth(request, {.stop = stop.get_token(), .unary_bytes = unary_bytes});
    });
    (by_stream ? arrived_by_stream : arrived_in_one).get_future().wait();
    stop.request_stop();
    const auto result = reply.get();
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().cause, "cancelled");
    EXPECT_EQ(result.error().message, "the caller stopped the call");
  }
}

TEST(SmoothingClient, DoesNotStartWhenAlreadyStopped) {
  std::atomic<int> calls = 0;
  const FakeServer server({.smooth = [&](auto&, auto&, auto&) { return ++calls, grpc::Status::OK; }});
  std::stop_source stop;
  stop.request_stop();
  const auto reply = SmoothingClient(server.address()).smooth({}, {.stop = stop.get_token()});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().cause, "cancelled");
  EXPECT_EQ(calls, 0);
}

TEST(SmoothingClient, NamesAServerThatDoesNotAnswer) {
  const auto reply = SmoothingClient("127.0.0.1:1").smooth({}, {.timeout = 20s, .retry = {.attempts = 2}});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(reply.error().cause, "unreachable");
  EXPECT_EQ(reply.error().attempts, 2);
}

TEST(SmoothingClient, ServesManyThreadsAtOnce) {
  const FakeServer server({.smooth = echo, .smooth_stream = echo_stream});
  const SmoothingClient client(server.address());
  std::vector<std::future<bool>> calls;
  for (int i = 0; i < 8; ++i) {
    calls.push_back(std::async(std::launch::async, [&client, i] {
      const std::string mesh(std::size_t{1} << 20, static_cast<char>('a' + i));
      const std::size_t unary_bytes = i % 2 == 0 ? 0 : std::size_t{4} << 20;
      for (int repeat = 0; repeat < 3; ++repeat) {
        const auto reply = client.smooth(request_with(mesh), {.unary_bytes = unary_bytes});
        if (!reply || reply->mesh() != mesh) return false;
      }
      return true;
    }));
  }
  for (auto& call : calls) EXPECT_TRUE(call.get());
}

}  // namespace
}  // namespace burnish::client
