// The life of the real server: start, full, cancel, deadline, drain.
#include "server/server.h"

#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/server/gate.h"
#include "tests/server/running_server.h"
#include "tests/support/eventually.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::any_port;
using testing::eventually;
using testing::Gate;
using testing::RawHttp;
using testing::reason_of;
using testing::RunningServer;

/// One message to any method and the first message back, both as bytes: health and reflection need no stubs
/// then.
std::string call_raw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                     const std::string& message) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 30s);
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  const grpc::Slice slice(message);
  grpc::ByteBuffer request(&slice, 1), response;
  auto call = stub.PrepareCall(&context, method, &queue);
  call->StartCall(nullptr);
  wait();
  call->Write(request, nullptr);
  wait();
  call->WritesDone(nullptr);
  wait();
  call->Read(&response, nullptr);
  std::string text;
  if (wait()) {
    std::vector<grpc::Slice> slices;
    if (response.Dump(&slices).ok()) {
      for (const auto& part : slices) text.append(reinterpret_cast<const char*>(part.begin()), part.size());
    }
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  return text;
}

/// grpc.health.v1: 1 is SERVING, 2 is NOT_SERVING.
int health_of(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  const std::string request = "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
  const std::string response = call_raw(channel, "/grpc.health.v1.Health/Check", request);
  return response.size() == 2 ? response[1] : -1;
}

/// Requests over both transports, each on a thread of its own; `ended` counts outcomes by name.
class Clients {
 public:
  Clients(RunningServer& server, int each) {
    for (int i = 0; i < each; ++i) {
      outcomes_.push_back(std::async(std::launch::async, [&server] {
        const grpc::Status status = server.smooth_mesh("mesh");
        return status.ok() ? std::string("ok") : reason_of(status);
      }));
      outcomes_.push_back(std::async(std::launch::async, [&server] {
        const HttpResponse response = server.http("POST", "/v1/smooth", "mesh");
        if (response.status == 200) return std::string("ok");
        return response.status == 503 ? std::string("SHUTTING_DOWN") : std::to_string(response.status);
      }));
    }
  }

  std::map<std::string, int> outcomes() {
    std::map<std::string, int> counts;
    for (auto& outcome : outcomes_) ++counts[outcome.get()];
    return counts;
  }

 private:
  std::vector<std::future<std::string>> outcomes_;
};

std::size_t jobs_in(RunningServer& server) { return server->runner().queued() + server->runner().running(); }

TEST(Server, ServesHealthAndReflection) {
  RunningServer server;
  EXPECT_EQ(server->state(), LifecycleState::Serving);
  EXPECT_EQ(health_of(server.channel(), ""), 1);
  EXPECT_EQ(health_of(server.channel(), "burnish.v1.SmoothingService"), 1);
  const std::string list_services = std::string("\x3a\x01*", 3);
  const std::string services = call_raw(
      server.channel(), "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", list_services);
  EXPECT_NE(services.find("burnish.v1.SmoothingService"), std::string::npos);
}

TEST(Server, WritesThePortsFileOnceBothServe) {
  Config config = any_port();
  config.ports_file = ::testing::TempDir() + "burnish_ports_" + new_request_id() + ".json";
  RunningServer server(config);
  std::ifstream file(config.ports_file);
  const auto ports = nlohmann::json::parse(file);
  EXPECT_EQ(ports["grpc"], server->grpc_address().text());
  EXPECT_EQ(ports["http"], server->http_address().text());
  EXPECT_NE(server->http_address().port, 0);
  std::filesystem::remove(config.ports_file);
}

TEST(Server, SaysThatThePortsFileCannotBeWritten) {
  Config config = any_port();
  config.ports_file = "/nonexistent-folder/ports.json";
  const auto started = Server::start(config);
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().cause, Cause::FileError);
}

TEST(Server, RefusesToStartWhenAPortIsTaken) {
  RunningServer first;
  for (const bool grpc : {true, false}) {
    Config config = any_port();
    (grpc ? config.grpc_listen : config.http_listen) = grpc ? first->grpc_address() : first->http_address();
    const auto second = Server::start(config);
    ASSERT_FALSE(second.ok()) << (grpc ? "gRPC" : "HTTP") << ": two servers would share the port";
    const std::string taken = (grpc ? first->grpc_address() : first->http_address()).text();
    EXPECT_NE(second.error().message.find(taken), std::string::npos) << second.error().message;
    EXPECT_NE(second.error().message.find(grpc ? "gRPC" : "HTTP"), std::string::npos)
        << second.error().message;
  }
  EXPECT_EQ(first.http("GET", "/livez").status, 200) << "the first one is unharmed";
}

TEST(Server, ServesOnIpv6) {
  Config config = any_port();
  config.http_listen.host = config.grpc_listen.host = "::1";
  auto started = Server::start(config);
  if (!started) GTEST_SKIP() << "this machine has no IPv6 loopback: " << started.error().message;
  const auto channel =
      grpc::CreateChannel(started.value()->grpc_address().text(), grpc::InsecureChannelCredentials());
  EXPECT_EQ(health_of(channel, ""), 1);
}

TEST(Server, RefusesAtOnceOnBothTransportsWhenTheQueueIsFull) {
  Gate gate;
  Config config = any_port();
  config.workers = 1;
  config.queue = 1;
  RunningServer server(config, gate.smoother());
  Clients accepted(server, 1);
  ASSERT_TRUE(eventually([&] { return jobs_in(server) == 2; }));
  const grpc::Status status = server.smooth_mesh("mesh");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(status), "QUEUE_FULL");
  EXPECT_LE(testing::detail_of<google::rpc::RetryInfo>(status)->retry_delay().seconds(), 2)
      << "two jobs, a second each until it is known better";
  const HttpResponse response = server.http("POST", "/v1/smooth", "mesh");
  EXPECT_EQ(response.status, 429);
  const int seconds = std::stoi(response.headers.at("Retry-After"));
  EXPECT_GE(seconds, 1) << "the one that waits, however long ago the first was refused";
  EXPECT_LE(seconds, 3) << "after the one refused before";
  gate.open();
  EXPECT_EQ(accepted.outcomes(), (std::map<std::string, int>{{"ok", 2}}));
}

TEST(Server, AnswersProbesWhileEveryPlaceIsTaken) {
  Gate gate;
  Config config = any_port();
  config.workers = 1;
  config.queue = 6;
  RunningServer server(config, gate.smoother());
  Clients accepted(server, 3);
  ASSERT_TRUE(eventually([&] { return jobs_in(server) == 6; }));
  EXPECT_EQ(server.http("GET", "/livez").status, 200);
  const std::string metrics = server.http("GET", "/metrics").body;
  EXPECT_NE(metrics.find("burnish_queue_depth 5"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("burnish_jobs_running 1"), std::string::npos);
  gate.open();
  EXPECT_EQ(accepted.outcomes(), (std::map<std::string, int>{{"ok", 6}}));
}

TEST(Server, AnswersADeadlineOnBothTransportsAndFreesTheWorker) {
  Gate gate;
  RunningServer server(any_port(), gate.smoother());
  v1::SmoothRequest request;
  v1::SmoothResponse response;
  request.set_mesh("mesh");
  EXPECT_EQ(server.smooth(request, response, 50ms).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(server.http("POST", "/v1/smooth?timeout_ms=50", "mesh").status, 504);
  EXPECT_TRUE(eventually([&] { return server->runner().running() == 0; }));
  EXPECT_TRUE(eventually([&] {
    const std::string metrics = server.http("GET", "/metrics").body;
    return metrics.find("outcomes_total{code=\"deadline_exceeded\",kind=\"smooth\",transport=\"grpc\"} 1") !=
               std::string::npos &&
           metrics.find("outcomes_total{code=\"deadline_exceeded\",kind=\"smooth\",transport=\"http\"} 1") !=
               std::string::npos;
  })) << "the server, too, calls it a deadline";
}

/// The real smoothing, which tells when it is in the middle of its iterations.
class Watched {
 public:
  SmoothFunction smoother() {
    return [this](const SmoothJob& job, const RunControl& run) {
      SmoothJob watched = job;
      watched.progress = [this](v1::SmoothStage stage, double fraction) {
        const bool iterates = stage == v1::SMOOTH_STAGE_SMOOTH && fraction > 0;
        if (iterates && !iterating_.exchange(true)) started_.set_value();
      };
      return SmoothService().smooth(watched, run);
    };
  }
  void wait_for_iterations() { started_.get_future().wait(); }

 private:
  std::atomic<bool> iterating_ = false;
  std::promise<void> started_;
};

/// With 100000 iterations a job of minutes.
std::string large_mesh() { return testing::to_obj(testing::with_noise(testing::grid(250), 0.001)); }

/// Away from oneTBB, which the thread sanitizer does not understand: suppressing its reports takes minutes.
Config one_core() {
  Config config = any_port();
  config.threads = 1;
  return config;
}

void expect_freed_soon(RunningServer& server, Clock::time_point gone, const char* transport) {
  ASSERT_TRUE(eventually([&] { return server->runner().running() == 0; }));
  const std::chrono::duration<double, std::milli> took = Clock::now() - gone;
  std::printf("[ MEASURED ] %s: worker free %.1f ms after the client left\n", transport, took.count());
  EXPECT_LT(took.count(), 1000) << "50 ms is the aim; the bound is wide for sanitizers on busy machines";
}

TEST(Server, AGrpcClientThatGoesAwayFreesItsWorker) {
  Watched job;
  RunningServer server(one_core(), job.smoother());
  v1::SmoothRequest request;
  v1::SmoothResponse response;
  request.set_mesh(large_mesh());
  request.mutable_options()->set_method("adaptive");
  request.mutable_options()->set_iterations(100'000);
  grpc::ClientContext context;
  auto call =
      std::async(std::launch::async, [&] { return server.stub().Smooth(&context, request, &response); });
  job.wait_for_iterations();
  const auto gone = Clock::now();
  context.TryCancel();
  expect_freed_soon(server, gone, "gRPC");
  EXPECT_EQ(call.get().error_code(), grpc::StatusCode::CANCELLED);
}

TEST(Server, AnHttpClientThatGoesAwayFreesItsWorker) {
  Watched job;
  RunningServer server(one_core(), job.smoother());
  RawHttp connection(server->http_address().port);
  ASSERT_TRUE(connection.send_request("POST", "/v1/smooth?method=adaptive&iterations=100000", large_mesh()));
  job.wait_for_iterations();
  const auto gone = Clock::now();
  connection.close();
  expect_freed_soon(server, gone, "HTTP");
}

TEST(Server, ACancelledCallLeavesTheQueueAtOnce) {
  Gate gate;
  Config config = any_port();
  config.workers = 1;
  RunningServer server(config, gate.smoother());
  auto running = std::async(std::launch::async, [&] { return server.smooth_mesh("mesh"); });
  gate.wait_for(1);
  grpc::ClientContext context;
  v1::SmoothRequest request;
  v1::SmoothResponse response;
  request.set_mesh("mesh");
  auto call =
      std::async(std::launch::async, [&] { return server.stub().Smooth(&context, request, &response); });
  RawHttp connection(server->http_address().port);
  ASSERT_TRUE(connection.send_request("POST", "/v1/smooth", "mesh"));
  ASSERT_TRUE(eventually([&] { return server->runner().queued() == 2; }));
  context.TryCancel();
  connection.close();
  EXPECT_TRUE(eventually([&] { return server->runner().queued() == 0; }));
  EXPECT_EQ(server->runner().running(), 1u);
  gate.open();
  EXPECT_TRUE(running.get().ok());
}

TEST(Server, FinishesEveryAcceptedJobBeforeStopping) {
  Gate gate;
  Config config = any_port();
  config.workers = 2;
  RunningServer server(config, gate.smoother());
  Clients accepted(server, 8);
  ASSERT_TRUE(eventually([&] { return jobs_in(server) == 16; }));
  auto stopping = std::async(std::launch::async, [&] { server->stop(60s); });
  ASSERT_TRUE(eventually([&] { return server->state() == LifecycleState::Draining; }));

  EXPECT_TRUE(eventually([&] { return health_of(server.channel(), "") == 2; }));
  EXPECT_EQ(health_of(server.channel(), "burnish.v1.SmoothingService"), 2);
  EXPECT_EQ(server.http("GET", "/readyz").status, 503);
  EXPECT_EQ(server.http("GET", "/livez").status, 200);
  EXPECT_EQ(server.http("POST", "/v1/smooth", "mesh").status, 503);
  EXPECT_EQ(server.smooth_mesh("mesh").error_code(), grpc::StatusCode::UNAVAILABLE);

  gate.open();
  EXPECT_EQ(accepted.outcomes(), (std::map<std::string, int>{{"ok", 16}}));
  stopping.get();
  EXPECT_EQ(server->state(), LifecycleState::Stopped);
}

TEST(Server, AnswersEveryAcceptedRequestWhenTheGraceEnds) {
  Gate gate;
  Config config = any_port();
  config.workers = 2;
  RunningServer server(config, gate.smoother());
  Clients accepted(server, 4);
  ASSERT_TRUE(eventually([&] { return jobs_in(server) == 8; }));
  server->stop(10ms);
  EXPECT_EQ(accepted.outcomes(), (std::map<std::string, int>{{"SHUTTING_DOWN", 8}}));
}

TEST(Server, ASecondStopCutsTheGraceShort) {
  Gate gate;
  RunningServer server(any_port(), gate.smoother());
  Clients accepted(server, 1);
  ASSERT_TRUE(eventually([&] { return jobs_in(server) == 2; }));
  auto stopping = std::async(std::launch::async, [&] { server->stop(1h); });
  ASSERT_TRUE(eventually([&] { return server->state() == LifecycleState::Draining; }));
  server->stop(0ms);
  EXPECT_EQ(accepted.outcomes(), (std::map<std::string, int>{{"SHUTTING_DOWN", 2}}));
  stopping.get();
  server->stop(0ms);  // safe to repeat
}

TEST(Server, CompletesAResponseThatIsBeingWrittenWhenItStops) {
  const std::string mesh(32'000'000, 'x');
  RunningServer server(any_port(), [&mesh](const SmoothJob&, const RunControl&) -> Result<SmoothResult> {
    SmoothResult result;
    result.mesh = mesh;
    return result;
  });
  RawHttp slow(server->http_address().port);
  ASSERT_TRUE(slow.send_request("POST", "/v1/smooth", "mesh"));
  ASSERT_EQ(slow.read_head().status, 200);
  auto stopping = std::async(std::launch::async, [&] { server->stop(60s); });
  ASSERT_TRUE(eventually([&] { return server->state() == LifecycleState::Draining; }));
  EXPECT_EQ(slow.read(mesh.size()).size(), mesh.size());
  stopping.get();
}

TEST(Server, DoesNotWaitForClientsThatOnlyStayConnected) {
  RunningServer server;
  grpc::GenericStub stub(server.channel());
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  auto watch =
      stub.PrepareCall(&context, "/grpc.health.v1.Health/Watch", &queue);  // ends only with the server
  watch->StartCall(nullptr);
  void* tag = nullptr;
  bool ok = false;
  ASSERT_TRUE(queue.Next(&tag, &ok) && ok);
  const auto begin = Clock::now();
  server->stop(60s);
  EXPECT_LT(Clock::now() - begin, 10s);
  grpc::Status status;
  watch->Finish(&status, nullptr);
  queue.Next(&tag, &ok);
}

TEST(Server, StopsWhileAStreamIsStillComing) {
  RunningServer server;
  grpc::ClientContext context;
  const auto stream = server.stub().SmoothStream(&context);
  v1::SmoothStreamRequest message;
  message.mutable_start();
  ASSERT_TRUE(stream->Write(message));
  message.set_mesh_chunk("v 0 0 0\n");
  ASSERT_TRUE(stream->Write(message));
  ASSERT_TRUE(eventually([&] {
    return server.http("GET", "/metrics").body.find("burnish_spooled_bytes 8") != std::string::npos;
  })) << "a stream that the server has not seen is cut without a reason";
  const auto begin = Clock::now();
  server->stop(60s);
  EXPECT_EQ(reason_of(stream->Finish()), "SHUTTING_DOWN");
  EXPECT_LT(Clock::now() - begin, 10s) << "nobody waits for bytes that may never come";
}

TEST(Server, StopsWhileABodyIsStillComing) {
  RunningServer server;
  RawHttp slow(server->http_address().port);
  ASSERT_TRUE(slow.send(
      "POST /v1/smooth HTTP/1.1\r\nHost: test\r\nExpect: 100-continue\r\nContent-Length: 1000\r\n\r\n"));
  ASSERT_EQ(slow.read_head().status, 100) << "the server waits for the body";
  auto stopping = std::async(std::launch::async, [&] { server->stop(60s); });
  ASSERT_TRUE(eventually([&] { return server->state() == LifecycleState::Draining; }));
  slow.send("v");
  EXPECT_EQ(slow.read_response().status, 503);
  slow.close();
  stopping.get();
}

}  // namespace
}  // namespace burnish
