// Load on a server.
#include "client/cli/load.h"

#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

namespace burnish::cli {
namespace {

using Seconds = std::chrono::duration<double>;
using std::chrono::milliseconds;

std::vector<Seconds> one_to(int last) {
  std::vector<Seconds> values;
  for (int i = 1; i <= last; ++i) values.emplace_back(i);
  return values;
}

TEST(Load, TakesPercentilesByNearestRank) {
  EXPECT_EQ(percentile(one_to(100), 0.5).count(), 50);
  EXPECT_EQ(percentile(one_to(100), 0.99).count(), 99);
  EXPECT_EQ(percentile(one_to(100), 0.999).count(), 100);
  EXPECT_EQ(percentile(one_to(100), 1).count(), 100);
  EXPECT_EQ(percentile(one_to(1), 0).count(), 1);
  EXPECT_EQ(percentile({}, 0.5).count(), 0);
}

TEST(Load, CallsWhatIsDueAndNoMore) {
  std::atomic<int> calls = 0;
  const auto outcome = load({.concurrency = 4, .rate = 1000, .duration = Seconds(0.05)},
                            [&] {
                              ++calls;
                              return "ok";
                            },
                            {});
  EXPECT_LE(calls, 50);
  EXPECT_EQ(outcome.calls() + outcome.unsent, 50U);
  EXPECT_EQ(outcome.latencies.size(), static_cast<std::size_t>(calls));
}

/// One call that takes long makes those that were due meanwhile late, though each takes no time itself.
TEST(Load, CountsTheWaitForALateCall) {
  std::atomic<int> calls = 0;
  const auto outcome = load({.concurrency = 1, .rate = 50, .duration = Seconds(1)},
                            [&] {
                              if (calls++ == 0) std::this_thread::sleep_for(milliseconds(300));
                              return "ok";
                            },
                            {});
  // Due every 20 ms: some fifteen waited, the median of them for 150 ms.
  const auto late =
      std::ranges::count_if(outcome.latencies, [](Seconds each) { return each.count() > 0.01; });
  EXPECT_GT(late, 8);
}

TEST(Load, CountsOutcomesByCauseAndStopsWhenTold) {
  std::stop_source stop;
  std::atomic<int> calls = 0;
  const auto outcome = load(
      {.concurrency = 2, .duration = Seconds(1000)},
      [&]() -> std::string {
        if (++calls >= 10) stop.request_stop();
        return calls % 2 == 0 ? "ok" : "queue_full";
      },
      stop.get_token());
  EXPECT_EQ(outcome.calls(), static_cast<std::uint64_t>(calls));
  EXPECT_GE(outcome.outcomes.at("queue_full"), 1U);
  const auto json = nlohmann::json::parse(load_json(outcome));
  EXPECT_EQ(json["calls"], outcome.calls());
  EXPECT_EQ(json["outcomes"]["queue_full"], outcome.outcomes.at("queue_full"));
  EXPECT_TRUE(json["latencyMs"].contains("p99.9"));
  std::ostringstream text;
  print_load(text, outcome);
  EXPECT_NE(text.str().find("queue_full"), std::string::npos);
}

}  // namespace
}  // namespace burnish::cli
