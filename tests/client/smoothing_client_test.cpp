#include "client/smoothing_client.h"

#include <gmock/gmock.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <thread>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace burnish::client {
namespace {

using namespace std::chrono_literals;

/// A server whose answers the test writes.
class FakeServer : public v1::SmoothingService::Service {
 public:
  using OnSmooth =
      std::function<grpc::Status(grpc::ServerContext&, const v1::SmoothRequest&, v1::SmoothResponse&)>;

  explicit FakeServer(OnSmooth on_smooth) : on_smooth_(std::move(on_smooth)) {
    grpc::ServerBuilder builder;
    builder.SetMaxReceiveMessageSize(-1);
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~FakeServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  grpc::Status Smooth(grpc::ServerContext* context, const v1::SmoothRequest* request,
                      v1::SmoothResponse* response) override {
    return on_smooth_(*context, *request, *response);
  }
  grpc::Status ListMethods(grpc::ServerContext*, const v1::ListMethodsRequest*,
                           v1::ListMethodsResponse* response) override {
    response->add_methods()->set_name("adaptive");
    return grpc::Status::OK;
  }

 private:
  OnSmooth on_smooth_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

grpc::Status echo(grpc::ServerContext&, const v1::SmoothRequest& request, v1::SmoothResponse& response) {
  response.set_mesh(request.mesh());
  response.mutable_report()->set_method(request.options().method());
  return grpc::Status::OK;
}

/// Holds the call until the client is gone.
grpc::Status until_cancelled(grpc::ServerContext& context) {
  while (!context.IsCancelled()) std::this_thread::sleep_for(1ms);
  return grpc::Status::CANCELLED;
}

v1::SmoothRequest request_with(const std::string& mesh) {
  v1::SmoothRequest request;
  request.set_mesh(mesh);
  request.mutable_options()->set_method("taubin");
  return request;
}

TEST(SmoothingClient, ReturnsTheReply) {
  const FakeServer server(echo);
  const auto reply = SmoothingClient(server.address()).smooth(request_with("v 0 0 0"));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh(), "v 0 0 0");
  EXPECT_EQ(reply->report().method(), "taubin");
}

TEST(SmoothingClient, ListsTheMethods) {
  const FakeServer server(echo);
  const auto reply = SmoothingClient(server.address()).list_methods();
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->methods(0).name(), "adaptive");
}

TEST(SmoothingClient, CarriesMessagesBeyondFourMegabytes) {
  const FakeServer server(echo);
  const std::string mesh(6 << 20, 'x');
  const auto reply = SmoothingClient(server.address()).smooth(request_with(mesh));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->mesh().size(), mesh.size());
}

TEST(SmoothingClient, NamesTheServersCauseAndField) {
  const FakeServer server([](auto&, auto&, auto&) {
    google::rpc::ErrorInfo info;
    info.set_domain("burnish");
    info.set_reason("BAD_OPTION");
    google::rpc::BadRequest bad_request;
    bad_request.add_field_violations()->set_field("lambda");
    google::rpc::Status details;
    details.add_details()->PackFrom(info);
    details.add_details()->PackFrom(bad_request);
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "lambda must be at most 1",
                        details.SerializeAsString());
  });
  const auto reply = SmoothingClient(server.address()).smooth({});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reply.error().cause, "bad_option");
  EXPECT_EQ(reply.error().message, "lambda must be at most 1");
  EXPECT_EQ(reply.error().field, "lambda");
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
        [&row](auto&, auto&, auto&) { return grpc::Status(row.code, "why", row.details); });
    const auto reply = SmoothingClient(server.address()).smooth({});
    ASSERT_FALSE(reply.ok()) << row.cause;
    EXPECT_EQ(reply.error().code, row.code) << row.cause;
    EXPECT_EQ(reply.error().cause, row.cause);
  }
}

TEST(SmoothingClient, KeepsItsDeadline) {
  const FakeServer server([](auto& context, auto&, auto&) { return until_cancelled(context); });
  const auto reply = SmoothingClient(server.address()).smooth({}, {.timeout = 50ms});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().cause, "deadline_exceeded");
}

TEST(SmoothingClient, StopsFromAnotherThread) {
  std::promise<void> arrived;
  const FakeServer server([&arrived](auto& context, auto&, auto&) {
    arrived.set_value();
    return until_cancelled(context);
  });
  std::stop_source stop;
  const SmoothingClient client(server.address());
  auto reply = std::async(std::launch::async, [&] { return client.smooth({}, {.stop = stop.get_token()}); });
  arrived.get_future().wait();
  stop.request_stop();
  const auto result = reply.get();
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().cause, "cancelled");
}

TEST(SmoothingClient, DoesNotStartWhenAlreadyStopped) {
  const FakeServer server(echo);
  std::stop_source stop;
  stop.request_stop();
  const auto reply = SmoothingClient(server.address()).smooth({}, {.stop = stop.get_token()});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().cause, "cancelled");
}

TEST(SmoothingClient, NamesAServerThatDoesNotAnswer) {
  const auto reply = SmoothingClient("127.0.0.1:1").smooth({}, {.timeout = 5s});
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(reply.error().cause, "unreachable");
}

TEST(SmoothingClient, ServesManyThreadsAtOnce) {
  const FakeServer server(echo);
  const SmoothingClient client(server.address());
  std::vector<std::future<bool>> calls;
  for (int i = 0; i < 8; ++i) {
    calls.push_back(std::async(std::launch::async, [&client, i] {
      const std::string mesh = "mesh " + std::to_string(i);
      const auto reply = client.smooth(request_with(mesh));
      return reply.ok() && reply->mesh() == mesh;
    }));
  }
  for (auto& call : calls) EXPECT_TRUE(call.get());
}

}  // namespace
}  // namespace burnish::client
