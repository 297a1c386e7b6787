// Callers that go away, go silent, do not read, or come while the server stops.
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/gate.h"
#include "tests/server/raw_http.h"
#include "tests/server/running_grpc.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using testing::eventually;
using testing::Gate;
using testing::RawHttp;
using testing::reason_of;
using testing::RunningGrpc;
using testing::SmoothCall;

constexpr std::size_t kMuch = std::size_t{64} << 20;  ///< more than the connection holds by itself

Result<SmoothResult> much(const SmoothJob&, const RunControl&) {
  return SmoothResult{.mesh = std::string(kMuch, 'x'), .report = {}};
}

Config one_worker() {
  Config config;
  config.workers = 1;
  return config;
}

std::string frame(char type, char flags, const std::string& payload, char stream) {
  const auto size = static_cast<char>(payload.size());
  return std::string{0, 0, size, type, flags, 0, 0, 0, stream} + payload;
}

std::string header(const std::string& name, const std::string& value) {
  return std::string{0, static_cast<char>(name.size())} + name + static_cast<char>(value.size()) + value;
}

std::string data(const google::protobuf::Message& message, bool last) {
  const std::string bytes = message.SerializeAsString();
  const char end_stream = last ? 1 : 0;
  return frame(0, end_stream, std::string{0, 0, 0, 0, static_cast<char>(bytes.size())} + bytes, 1);
}

/// A SmoothStream with a start and one chunk in HTTP/2's own frames: the caller of a bare socket can drop it.
std::string half_a_stream(bool whole) {
  v1::SmoothStreamRequest start, chunk;
  start.mutable_start();
  chunk.set_mesh_chunk("mesh");
  const std::string head = header(":method", "POST") + header(":scheme", "http") +
                           header(":authority", "test") +
                           header(":path", "/burnish.v1.SmoothingService/SmoothStream") +
                           header("te", "trailers") + header("content-type", "application/grpc");
  return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + frame(4, 0, "", 0) + frame(1, 4, head, 1) + data(start, false) +
         data(chunk, whole);
}

bool has_bytes(RunningGrpc& server) { return server.jobs().spool().bytes() > 0; }

TEST(GrpcCaller, CancelsWhileItUploads) {
  RunningGrpc server;
  SmoothCall call(server);
  call.start();
  call.mesh("v 0 0 0\n");
  ASSERT_TRUE(eventually([&] { return has_bytes(server); }));
  call.context.TryCancel();
  EXPECT_EQ(call.finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, CancelsWhileItWaits) {
  Gate gate;
  RunningGrpc server({.config = one_worker(), .smooth = gate.smoother()});
  SmoothCall first(server), second(server);
  first.start();
  first.upload("mesh");
  gate.wait_for(1);
  second.start();
  second.upload("mesh");
  ASSERT_TRUE(second.read_until(v1::SMOOTH_STAGE_QUEUE));
  second.context.TryCancel();
  EXPECT_TRUE(eventually([&] { return server.runner().queued() == 0; }));
  EXPECT_EQ(second.finish().error_code(), grpc::StatusCode::CANCELLED);
  gate.open();
  EXPECT_TRUE(first.finish().ok());
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, CancelsWhileTheJobRuns) {
  RunningGrpc server({.config = one_worker()});
  SmoothCall call(server);
  v1::SmoothStart start;
  start.mutable_options()->set_method("laplacian");
  start.mutable_options()->set_iterations(100'000);
  call.start(start);
  call.upload(testing::to_obj(testing::with_noise(testing::grid(200), 0.001)));
  ASSERT_TRUE(call.read_until(v1::SMOOTH_STAGE_SMOOTH));
  call.context.TryCancel();
  EXPECT_EQ(call.finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, CancelsWhileItDownloads) {
  RunningGrpc server({.smooth = much});
  SmoothCall call(server);
  call.start();
  call.upload("mesh");
  v1::SmoothStreamResponse message;
  while (call.stream->Read(&message) && !message.has_mesh_chunk()) continue;
  ASSERT_TRUE(message.has_mesh_chunk());
  call.context.TryCancel();
  call.finish();
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, VanishesWithItsConnection) {
  Gate gate;
  RunningGrpc server({.config = one_worker(), .smooth = gate.smoother()});
  for (const bool whole : {true, false}) {
    RawHttp connection(server.server().address().port);
    ASSERT_TRUE(connection.send(half_a_stream(whole)));
    if (whole) {
      gate.wait_for(1);
    } else {
      ASSERT_TRUE(eventually([&] { return has_bytes(server); }));
    }
    connection.close();
    EXPECT_TRUE(eventually([&] { return server.runner().running() == 0 && !has_bytes(server); }));
  }
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, HoldsNoWorkerByNotReading) {
  RunningGrpc server({.config = one_worker(), .smooth = much});
  SmoothCall lazy(server), honest(server);
  lazy.start();
  lazy.upload("mesh");
  ASSERT_TRUE(eventually([&] { return !has_bytes(server) && server.runner().running() == 0; }));
  honest.start();
  honest.upload("mesh");
  EXPECT_TRUE(honest.finish().ok());
  EXPECT_TRUE(lazy.finish().ok()) << "late, but all of it";
  EXPECT_EQ(lazy.result.size(), kMuch);
}

TEST(GrpcCaller, IsGivenUpWhenItStopsReading) {
  RunningGrpc server({.smooth = much, .idle = 200ms});
  SmoothCall call(server);
  call.start();
  call.upload("mesh");
  EXPECT_TRUE(server.forgets_everything());
  EXPECT_FALSE(call.finish().ok());
}

TEST(GrpcCaller, IsGivenUpWhenItGoesSilentInItsUpload) {
  RunningGrpc server({.idle = 100ms});
  for (const bool started : {false, true}) {
    SmoothCall call(server);
    if (started) call.start();
    const grpc::Status status = call.finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    EXPECT_EQ(reason_of(status), "REQUEST_TIMEOUT");
  }
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, IsNotIdleWhileItsJobRuns) {
  Gate gate;
  RunningGrpc server({.smooth = gate.smoother(), .idle = 50ms});
  SmoothCall call(server), silent(server);
  call.start();
  call.upload("mesh");
  gate.wait_for(1);
  EXPECT_EQ(reason_of(silent.finish()), "REQUEST_TIMEOUT") << "an idle time passed meanwhile";
  gate.open();
  EXPECT_TRUE(call.finish().ok());
}

TEST(GrpcCaller, HasItsDeadlineInEveryPhase) {
  Gate gate;
  RunningGrpc server({.smooth = gate.smoother()});
  SmoothCall uploading(server, 100ms), running(server, 100ms);
  uploading.start();
  uploading.mesh("mesh");
  running.start();
  running.upload("mesh");
  EXPECT_EQ(uploading.finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(running.finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, IsRefusedAtOnceWhenTheServerStopsInItsUpload) {
  Gate gate;
  RunningGrpc server({.smooth = gate.smoother()});
  SmoothCall accepted(server), uploading(server);
  accepted.start();
  accepted.upload("mesh");
  gate.wait_for(1);
  uploading.start();
  uploading.mesh("mesh");
  ASSERT_TRUE(eventually([&] { return server.jobs().spool().bytes() > 4; }));
  server.lifecycle().move_to(LifecycleState::Draining);
  server.server().refuse_uploads();
  const grpc::Status status = uploading.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(reason_of(status), "SHUTTING_DOWN");
  EXPECT_TRUE(testing::detail_of<google::rpc::RetryInfo>(status).has_value());
  SmoothCall late(server);
  EXPECT_EQ(reason_of(late.finish()), "SHUTTING_DOWN") << "before it sent anything";
  gate.open();
  EXPECT_TRUE(accepted.finish().ok());
  EXPECT_TRUE(server.forgets_everything());
}

TEST(GrpcCaller, IsAnsweredWhenManyCancelAtAnyMoment) {
  RunningGrpc server({.config = one_worker()});
  const std::string mesh = testing::to_obj(testing::with_noise(testing::sphere(2), 0.02));
  std::vector<std::future<void>> callers;
  for (int thread = 0; thread < 4; ++thread) {
    callers.push_back(std::async(std::launch::async, [&, thread] {
      for (int i = 0; i < 25; ++i) {
        SmoothCall call(server);
        auto cancel = std::async(std::launch::async, [&] {
          // Not to wait for anything: it spreads the cancels over the life of a call.
          std::this_thread::sleep_for(std::chrono::microseconds(150 * i * (thread + 1)));
          call.context.TryCancel();
        });
        call.start();
        call.upload(mesh, 4096);
        call.finish();
        cancel.get();
      }
    }));
  }
  for (auto& caller : callers) caller.get();
  EXPECT_TRUE(server.forgets_everything());
}

}  // namespace
}  // namespace burnish
