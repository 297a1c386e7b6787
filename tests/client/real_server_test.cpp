// The client against the server that ships, in process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "client/smoothing_client.h"
#include "server/server.h"
#include "tests/client/temporary_folder.h"
#include "tests/server/gate.h"
#include "tests/support/eventually.h"
#include "tests/support/shapes.h"

namespace burnish::client {
namespace {

using namespace std::chrono_literals;

Config any_port() {
  Config config;
  config.grpc_listen = config.http_listen = {"127.0.0.1", 0};
  return config;
}

std::unique_ptr<Server> start(const Config& config, SmoothFunction smooth = {}) {
  return std::move(Server::start(config, std::move(smooth)).value());
}

SmoothingClient client_of(const Server& server) { return SmoothingClient(server.grpc_address().text()); }

v1::SmoothRequest noisy_sphere(int levels) {
  v1::SmoothRequest request;
  request.set_mesh(testing::to_obj(testing::with_noise(testing::sphere(levels), 0.02)));
  return request;
}

TEST(RealServer, SmoothsToTheSameBytesInOneMessageAndByStream) {
  const auto server = start(any_port());
  v1::SmoothRequest request = noisy_sphere(5);  // more than a chunk
  request.set_reference(testing::to_obj(testing::sphere(5)));
  const auto unary = client_of(*server).smooth(request);
  ASSERT_TRUE(unary.ok()) << unary.error().message;
  const auto streamed =
      client_of(*server).smooth(request, {.compression = Compression::Gzip, .unary_bytes = 0});
  ASSERT_TRUE(streamed.ok()) << streamed.error().message;
  EXPECT_TRUE(streamed->mesh() == unary->mesh());
  EXPECT_EQ(streamed->format(), unary->format());
  EXPECT_EQ(streamed->report().errors().ev(), unary->report().errors().ev());
  EXPECT_EQ(streamed->report().errors().against(), "reference");
}

TEST(RealServer, TellsItsStagesInOrder) {
  const auto server = start(any_port());
  std::vector<int> stages;
  const auto note = [&](const v1::SmoothProgress& now) { stages.push_back(now.stage()); };
  const auto reply = client_of(*server).smooth(noisy_sphere(4), {.progress = note});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_FALSE(stages.empty());
  EXPECT_TRUE(std::ranges::is_sorted(stages)) << ::testing::PrintToString(stages);
}

TEST(RealServer, ComparesInOneMessageAndByStream) {
  const auto server = start(any_port());
  v1::CompareRequest request;
  request.set_reference(testing::to_obj(testing::sphere(3)));
  request.set_mesh(testing::to_obj(testing::sphere(5)));
  const auto unary = client_of(*server).compare(request);
  ASSERT_TRUE(unary.ok()) << unary.error().message;
  const auto streamed = client_of(*server).compare(request, {.unary_bytes = 0});
  ASSERT_TRUE(streamed.ok()) << streamed.error().message;
  EXPECT_EQ(streamed->errors().ev(), unary->errors().ev());
  EXPECT_EQ(streamed->reference().triangles(), 20u * 64);
  EXPECT_EQ(streamed->mesh().triangles(), 20u * 1024);
}

TEST(RealServer, AnswersOnAUnixDomainSocket) {
  const cli::TemporaryFolder folder;
  Config config = any_port();
  config.grpc_listen = {.host = "", .port = 0, .path = folder / "burnish.sock"};
  const auto server = start(config);
  const auto reply = SmoothingClient("unix:" + config.grpc_listen.path).list_methods();
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->methods(0).name(), "auto");
}

TEST(RealServer, RefusesWhatDoesNotFitBeforeItIsSent) {
  Config config = any_port();
  config.limits.mesh.max_bytes = 1000;
  const auto server = start(config);
  v1::SmoothRequest request;
  request.set_mesh(std::string(64 << 20, ' '));
  const auto reply = client_of(*server).smooth(request);
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().cause, "too_large");
  EXPECT_THAT(reply.error().message, ::testing::HasSubstr("(max-bytes)"));
}

TEST(RealServer, TakesACallThatFirstFoundItsQueueFull) {
  Config config = any_port();
  config.workers = config.queue = 1;
  std::atomic<bool> shut = false;  // the server's own first job passes
  testing::Gate gate;
  const auto server = start(config, [&, held = gate.smoother()](const SmoothJob& job, const RunControl& run) {
    return shut ? held(job, run) : SmoothService().smooth(job, run);
  });
  shut = true;
  const SmoothingClient client = client_of(*server);
  std::vector<std::future<bool>> holders;
  for (int i = 0; i < 2; ++i) {
    holders.push_back(
        std::async(std::launch::async, [&client] { return client.smooth(noisy_sphere(1)).ok(); }));
  }
  EXPECT_TRUE(
      testing::eventually([&] { return server->runner().running() == 1 && server->runner().queued() == 1; }));
  CallOptions options;
  std::chrono::milliseconds asked{};
  options.retry.wait = [&](std::chrono::milliseconds delay, const std::stop_token&) {
    asked = delay;
    gate.open();
    for (auto& holder : holders) EXPECT_TRUE(holder.get());
    return true;
  };
  options.retry.jitter = [] { return 0.0; };
  const auto reply = client.smooth(noisy_sphere(1), options);
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_GT(asked, 0ms);  // the server's own word: the jitter adds nothing
}

}  // namespace
}  // namespace burnish::client
