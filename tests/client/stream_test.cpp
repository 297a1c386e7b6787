// Calls by stream: when, in which pieces, and what a server's early word does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <thread>

#include "client/smoothing_client.h"
#include "tests/client/fake_server.h"

namespace burnish::client {
namespace {

using ::testing::ElementsAre;

constexpr std::size_t kMiB = std::size_t{1} << 20;

/// Bytes that show when a piece is lost or out of place.
std::string mesh_of(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 31 + (i >> 12));
  return bytes;
}

v1::SmoothRequest smooth_request(std::size_t mesh_bytes, std::size_t reference_bytes = 0) {
  v1::SmoothRequest request;
  request.set_mesh(mesh_of(mesh_bytes));
  request.set_reference(mesh_of(reference_bytes));
  return request;
}

v1::CompareRequest compare_request(std::size_t mesh_bytes, std::size_t reference_bytes) {
  v1::CompareRequest request;
  request.set_mesh(mesh_of(mesh_bytes));
  request.set_reference(mesh_of(reference_bytes));
  return request;
}

void ignore(const v1::SmoothProgress&) {}

TEST(Stream, IsTakenBySizeOrForProgress) {
  std::atomic<int> streams = 0;
  const auto count_stream = [&](auto&, SmoothStream& stream) {
    ++streams;
    receive(stream);
    send_report(stream);
    return grpc::Status::OK;
  };
  const FakeServer server({.smooth = echo, .smooth_stream = count_stream});
  const SmoothingClient client(server.address());
  struct Row {
    std::size_t mesh, reference;
    CallOptions options;
    bool by_stream;
  };
  const Row rows[] = {
      {4 * kMiB, 0, {}, false},
      {4 * kMiB + 1, 0, {}, true},
      {2 * kMiB, 2 * kMiB, {}, false},
      {2 * kMiB, 2 * kMiB + 1, {}, true},
      {100, 0, {.unary_bytes = 100}, false},
      {100, 1, {.unary_bytes = 100}, true},
      {100, 0, {.progress = ignore}, true},
  };
  for (const Row& row : rows) {
    streams = 0;
    const auto reply = client.smooth(smooth_request(row.mesh, row.reference), row.options);
    ASSERT_TRUE(reply.ok()) << reply.error().message;
    EXPECT_EQ(streams, row.by_stream ? 1 : 0) << row.mesh << " + " << row.reference;
  }
}

TEST(Stream, CarriesTheRequestInChunksOfItsDeclaredSizes) {
  std::promise<Upload<v1::SmoothStart>> received;
  const FakeServer server({.smooth_stream = [&](auto&, SmoothStream& stream) {
    received.set_value(receive(stream));
    send_report(stream);
    return grpc::Status::OK;
  }});
  v1::SmoothRequest request = smooth_request(3 * kMiB + 7, 2 * kMiB);
  request.set_format(v1::MESH_FORMAT_DRACO);
  request.set_reference_format(v1::MESH_FORMAT_OBJ);
  request.mutable_options()->set_method("taubin");
  ASSERT_TRUE(SmoothingClient(server.address()).smooth(request).ok());
  const auto upload = received.get_future().get();
  EXPECT_TRUE(upload.mesh == request.mesh());
  EXPECT_TRUE(upload.reference == request.reference());
  EXPECT_EQ(upload.largest_chunk, kMiB);
  EXPECT_EQ(upload.start.mesh_bytes(), request.mesh().size());
  EXPECT_EQ(upload.start.reference_bytes(), request.reference().size());
  EXPECT_EQ(upload.start.format(), v1::MESH_FORMAT_DRACO);
  EXPECT_EQ(upload.start.reference_format(), v1::MESH_FORMAT_OBJ);
  EXPECT_EQ(upload.start.options().method(), "taubin");
}

TEST(Stream, PutsTheAnswerTogether) {
  const FakeServer server({.smooth_stream = echo_stream});
  const v1::SmoothRequest request = smooth_request(9 * kMiB + 1);
  const auto reply = SmoothingClient(server.address()).smooth(request);
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_TRUE(reply->mesh() == request.mesh());
  EXPECT_EQ(reply->format(), v1::MESH_FORMAT_OBJ);
}

TEST(Stream, CarriesAComparison) {
  std::promise<Upload<v1::CompareStart>> received;
  const FakeServer server({.compare_stream = [&](CompareStream& stream, v1::CompareResponse& response) {
    received.set_value(receive(stream));
    response.set_request_id("by stream");
    return grpc::Status::OK;
  }});
  v1::CompareRequest request = compare_request(3 * kMiB, 2 * kMiB);
  request.set_format(v1::MESH_FORMAT_DRACO);
  request.set_reference_format(v1::MESH_FORMAT_OBJ);
  const auto reply = SmoothingClient(server.address()).compare(request);
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->request_id(), "by stream");
  const auto upload = received.get_future().get();
  EXPECT_TRUE(upload.mesh == request.mesh());
  EXPECT_TRUE(upload.reference == request.reference());
  EXPECT_EQ(upload.start.mesh_bytes(), request.mesh().size());
  EXPECT_EQ(upload.start.reference_bytes(), request.reference().size());
  EXPECT_EQ(upload.start.format(), v1::MESH_FORMAT_DRACO);
  EXPECT_EQ(upload.start.reference_format(), v1::MESH_FORMAT_OBJ);
}

TEST(Stream, TellsProgressInOrderOnTheCallingThread) {
  const FakeServer server({.smooth_stream = [](auto&, SmoothStream& stream) {
    receive(stream);
    send_progress(stream, v1::SMOOTH_STAGE_QUEUE);
    send_progress(stream, v1::SMOOTH_STAGE_SMOOTH, 0.25);
    send_progress(stream, v1::SMOOTH_STAGE_SMOOTH, 0.75);
    send_progress(stream, v1::SMOOTH_STAGE_ENCODE);
    send_report(stream);
    return grpc::Status::OK;
  }});
  std::vector<std::pair<int, double>> seen;
  const auto caller = std::this_thread::get_id();
  const auto reply = SmoothingClient(server.address())
                         .smooth(smooth_request(10), {.progress = [&](const v1::SmoothProgress& now) {
                                   EXPECT_EQ(std::this_thread::get_id(), caller);
                                   seen.emplace_back(now.stage(), now.fraction());
                                 }});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_THAT(seen,
              ElementsAre(std::pair(1, 0.0), std::pair(4, 0.25), std::pair(4, 0.75), std::pair(6, 0.0)));
}

TEST(Stream, ReadsWhileItWrites) {
  // More than both sides' windows hold: a client that wrote first and read later would stand still.
  const FakeServer server({.smooth_stream = [](auto&, SmoothStream& stream) {
    for (int i = 0; i < 32; ++i) send_chunk(stream, std::string(kMiB, 'x'));
    receive(stream);
    send_report(stream);
    return grpc::Status::OK;
  }});
  const auto reply = SmoothingClient(server.address())
                         .smooth(smooth_request(32 * kMiB), {.timeout = std::chrono::seconds(60)});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh().size(), 32 * kMiB);
}

TEST(Stream, NamesARefusalThatComesBeforeTheUploadIsDone) {
  const auto refuse = [](auto& stream, auto part) {
    stream.Read(&part);
    return refusal(grpc::StatusCode::INVALID_ARGUMENT, "UNKNOWN_METHOD", "method");
  };
  const FakeServer server(
      {.smooth_stream = [&](auto&,
                            SmoothStream& stream) { return refuse(stream, v1::SmoothStreamRequest()); },
       .compare_stream = [&](CompareStream& stream,
                             auto&) { return refuse(stream, v1::CompareStreamRequest()); }});
  const SmoothingClient client(server.address());
  const auto check = [](const auto& reply) {
    ASSERT_FALSE(reply.ok());
    EXPECT_EQ(reply.error().cause, "unknown_method") << reply.error().message;
    EXPECT_EQ(reply.error().field, "method");
    EXPECT_EQ(reply.error().attempts, 1);
  };
  const v1::SmoothRequest mesh = smooth_request(32 * kMiB);
  const v1::CompareRequest meshes = compare_request(16 * kMiB, 16 * kMiB);
  for (int repeat = 0; repeat < 5; ++repeat) {
    check(client.smooth(mesh));
    check(client.compare(meshes));
  }
}

TEST(Stream, EndsTheCallWhenTheProgressFunctionThrows) {
  std::promise<bool> cancelled;
  const FakeServer server({.smooth_stream = [&](grpc::ServerContext& context, SmoothStream& stream) {
    send_progress(stream, v1::SMOOTH_STAGE_QUEUE);
    const grpc::Status status = until_cancelled(context);
    cancelled.set_value(context.IsCancelled());
    return status;
  }});
  const auto fail = [](const v1::SmoothProgress&) { throw std::runtime_error("no room on the screen"); };
  const auto reply = SmoothingClient(server.address()).smooth(smooth_request(32 * kMiB), {.progress = fail});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().cause, "internal");
  EXPECT_EQ(reply.error().message, "no room on the screen");
  EXPECT_TRUE(cancelled.get_future().get());
}

TEST(Stream, NamesAnAnswerWithoutAReport) {
  const FakeServer server({.smooth_stream = [](auto&, SmoothStream& stream) {
    receive(stream);
    send_chunk(stream, "v 0 0 0");
    return grpc::Status::OK;
  }});
  const auto reply = SmoothingClient(server.address()).smooth(smooth_request(10), {.progress = ignore});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().cause, "internal");
  EXPECT_THAT(reply.error().message, ::testing::HasSubstr("report"));
}

}  // namespace
}  // namespace burnish::client
