#include "server/jobs/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "core/io/estimate.h"
#include "core/smooth/registry.h"
#include "server/security/tokens.h"
#include "tests/server/gate.h"
#include "tests/server/jobs_house.h"
#include "tests/support/eventually.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace std::chrono_literals;
using testing::Gate;
using ::testing::HasSubstr;

struct House : testing::JobsHouse {
  explicit House(const RequestLimits& limits = {}, const JobRunnerOptions& options = {.workers = 1},
                 SmoothFunction smooth = {})
      : JobsHouse({limits, options, std::move(smooth)}) {}

  /// What became of a request to smooth.
  std::future<Result<SmoothResult>> smooth(SmoothJob job, const Caller& caller = {}) {
    auto promise = std::make_shared<std::promise<Result<SmoothResult>>>();
    auto future = promise->get_future();
    jobs.smooth(caller, std::move(job),
                [promise](Result<SmoothResult> result) { promise->set_value(std::move(result)); });
    return future;
  }
};

const std::string& mesh() {
  static const std::string kMesh = testing::to_obj(testing::sphere(3));
  return kMesh;
}

TEST(Jobs, SmoothsAndComparesUnderTheCallersName) {
  House house;
  SmoothJob job{.mesh = mesh()};
  job.options.set_method("adaptive");  // auto leaves a clean mesh as it is
  const auto smoothed = house.smooth(job, {.request_id = "mine"}).get();
  ASSERT_TRUE(smoothed.ok());
  EXPECT_EQ(smoothed->report.request_id(), "mine");
  std::promise<Result<v1::CompareResponse>> ended;
  house.jobs.compare({.request_id = "other"}, {.reference = mesh(), .mesh = smoothed->mesh},
                     [&](Result<v1::CompareResponse> result) { ended.set_value(std::move(result)); });
  const auto compared = ended.get_future().get();
  ASSERT_TRUE(compared.ok());
  EXPECT_EQ(compared->request_id(), "other");
  EXPECT_GT(compared->errors().ev(), 0);
}

TEST(Jobs, RefuseByEstimatedMemoryBeforeAnythingIsDecoded) {
  House house({}, {.workers = 1, .max_memory = 1000});
  const auto refused = house.smooth({.mesh = mesh()}).get();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::TooLarge);
  EXPECT_THAT(refused.error().message, HasSubstr("(max-memory)"));
}

TEST(Jobs, CountTheMemoryOfTheMethod) {
  const std::string text = testing::to_obj(testing::sphere(4));
  const Estimate said = estimate(std::string_view(text), Format::Obj);
  const std::uint64_t light = work_memory_of("laplacian").bytes(said.vertices, said.triangles);
  House house({}, {.workers = 1, .max_memory = text.size() + said.memory_with(light)});
  SmoothJob job{.mesh = text};
  job.options.set_iterations(1);
  job.options.set_method("laplacian");
  EXPECT_TRUE(house.smooth(job).get().ok());
  job.options.set_method("bilateral_normals");
  const auto refused = house.smooth(job).get();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::TooLarge);
}

TEST(Jobs, CountTheTimeOfTheMethod) {
  House house;
  const std::string text = testing::to_obj(testing::with_noise(testing::sphere(4), 0.2));
  const auto ask = [&](const char* method, std::uint32_t iterations) {
    SmoothJob job{.mesh = text};
    job.options.set_method(method);
    job.options.set_iterations(iterations);
    return house.smooth(job, {.deadline = RunControl::Clock::now() + 10s}).get();
  };
  EXPECT_TRUE(ask("laplacian", 5).ok());  // from now on the server knows how fast it is
  EXPECT_TRUE(ask("laplacian", 10).ok());
  const auto refused = ask("guided", 100'000);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::DeadlineExceeded);
  EXPECT_THAT(refused.error().message, HasSubstr("are expected to take"));
}

TEST(Jobs, ExpectWhatSubmitWillSay) {
  Gate gate;
  House house({.mesh = {.max_bytes = 1000}}, {.workers = 1, .queue = 0}, gate.smoother());
  EXPECT_TRUE(house.jobs.expect({}, 1000, 1000).ok());
  const auto large = house.jobs.expect({}, 1001, 0);
  ASSERT_FALSE(large.ok());
  EXPECT_EQ(large.error().cause, Cause::TooLarge);
  EXPECT_EQ(house.jobs.expect({}, 0, 1001).error().cause, Cause::TooLarge);
  auto running = house.smooth({.mesh = "v 0 0 0\n"});
  gate.wait_for(1);
  EXPECT_EQ(house.jobs.expect({}, 0, 0).error().cause, Cause::QueueFull);
  gate.open();
  EXPECT_TRUE(running.get().ok());
  house.lifecycle.move_to(LifecycleState::Draining);
  EXPECT_EQ(house.jobs.expect({}, 0, 0).error().cause, Cause::ShuttingDown);
}

TEST(Jobs, RefusedByAFullQueuePayNothing) {
  const cli::TemporaryFolder folder;
  const auto tokens =
      Tokens::load(
          folder.write("tokens.json", R"({"tokens": [{"name": "a", "bytesPerSecond": 1, "sha256": ")" +
                                          sha256_of("secret") + R"("}]})"))
          .value();
  const Caller owner{.owner = "a"};
  const std::string bytes(60, '#');
  const SmoothJob minutes_worth{.mesh = bytes};
  Gate gate;
  House house({}, {.workers = 1, .queue = 0}, gate.smoother());
  auto running = house.smooth({.mesh = "v 0 0 0\n"});
  gate.wait_for(1);
  house.jobs.ask_for(tokens.get());
  EXPECT_EQ(house.smooth(minutes_worth, owner).get().error().cause, Cause::QueueFull);
  gate.open();
  EXPECT_TRUE(running.get().ok());
  // A job is answered a little before its worker is free again.
  const auto has_place = [&] { return house.jobs.expect(owner, 0, 0).ok(); };
  ASSERT_TRUE(testing::eventually(has_place));
  EXPECT_TRUE(house.smooth(minutes_worth, owner).get().ok());
  ASSERT_TRUE(testing::eventually(has_place));
  EXPECT_EQ(house.smooth(minutes_worth, owner).get().error().cause, Cause::QuotaExceeded);
}

TEST(Jobs, SelfTestGoesThroughAWorkerAndFailsWhenThereIsNone) {
  House house;
  EXPECT_TRUE(house.jobs.self_test().ok());
  house.runner.drain(0ms);
  EXPECT_FALSE(house.jobs.self_test().ok());
}

TEST(Jobs, DoNotServeOnceTheWorkersAreStuck) {
  std::promise<void> let_go;
  const auto stuck = [held = let_go.get_future().share()](const SmoothJob&, const RunControl&) {
    held.wait();
    return Result<SmoothResult>(SmoothResult());
  };
  House house({}, {.workers = 1, .longest_run = 1ms, .overrun = 5ms}, stuck);
  EXPECT_TRUE(house.jobs.serving());
  auto held = house.smooth({.mesh = mesh()});
  EXPECT_TRUE(testing::eventually([&] { return !house.jobs.serving(); }));
  let_go.set_value();
  EXPECT_TRUE(testing::eventually([&] { return house.jobs.serving(); }));
}

}  // namespace
}  // namespace burnish
