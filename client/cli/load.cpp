#include "client/cli/load.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <numeric>
#include <ostream>
#include <thread>

namespace burnish::cli {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

struct Share {
  const char* name;
  double share;
};
constexpr Share kShares[] = {{"p50", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"p99.9", 0.999}, {"max", 1}};

Clock::duration steps(Seconds seconds) { return std::chrono::duration_cast<Clock::duration>(seconds); }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

/// Sleeps until `due`; false when stopped before.
bool wait_until(Clock::time_point due, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  return !stopped.wait_until(lock, stop, due, [&stop] { return stop.stop_requested(); });
}

}  // namespace

std::uint64_t LoadOutcome::calls() const {
  return std::accumulate(outcomes.begin(), outcomes.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& each) { return sum + each.second; });
}

LoadOutcome load(const LoadOptions& options, const std::function<std::string()>& call,
                 const std::stop_token& stop) {
  const auto begin = Clock::now(), end = begin + steps(options.duration);
  const auto due_calls = static_cast<std::uint64_t>(std::ceil(options.rate * options.duration.count()));
  std::atomic<std::uint64_t> next = 0;
  std::mutex mutex;
  LoadOutcome total;
  const auto caller = [&] {
    LoadOutcome own;
    while (!stop.stop_requested() && Clock::now() < end) {
      auto due = Clock::now();
      if (options.rate > 0) {
        const std::uint64_t number_of_call = next++;
        if (number_of_call >= due_calls) break;
        due = begin + steps(Seconds(static_cast<double>(number_of_call) / options.rate));
        if (!wait_until(due, stop)) break;
      }
      const std::string outcome = call();
      ++own.outcomes[outcome];
      if (outcome == "ok") own.latencies.push_back(Clock::now() - due);
    }
    const std::lock_guard lock(mutex);
    total.latencies.insert(total.latencies.end(), own.latencies.begin(), own.latencies.end());
    for (const auto& [name, count] : own.outcomes) total.outcomes[name] += count;
  };
  {
    std::vector<std::jthread> callers;
    for (unsigned i = 0; i < options.concurrency; ++i) callers.emplace_back(caller);
  }
  total.took = Clock::now() - begin;
  if (options.rate > 0 && !stop.stop_requested())
    total.unsent = due_calls - std::min(due_calls, total.calls());
  std::ranges::sort(total.latencies);
  return total;
}

Seconds percentile(const std::vector<Seconds>& ascending, double share) {
  if (ascending.empty()) return Seconds(0);
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(ascending.size())));
  return ascending[std::clamp<std::size_t>(rank, 1, ascending.size()) - 1];
}

void print_load(std::ostream& out, const LoadOutcome& outcome) {
  out << "calls     " << outcome.calls() << " in " << number(outcome.took.count()) << " s, "
      << number(static_cast<double>(outcome.latencies.size()) / outcome.took.count())
      << " answered a second\n";
  out << "outcomes ";
  for (const auto& [name, count] : outcome.outcomes) out << ' ' << name << ' ' << count;
  out << "\nlatency  ";
  for (const Share& each : kShares)
    out << ' ' << each.name << ' ' << number(1000 * percentile(outcome.latencies, each.share).count())
        << " ms";
  out << "  (from when each call was due)\n";
  if (outcome.unsent > 0) out << "unsent    " << outcome.unsent << " calls were due and nobody was free\n";
}

std::string load_json(const LoadOutcome& outcome) {
  std::string json = "{\"calls\": " + std::to_string(outcome.calls()) +
                     ", \"seconds\": " + number(outcome.took.count()) +
                     ", \"unsent\": " + std::to_string(outcome.unsent) + ", \"latencyMs\": {";
  const char* comma = "";
  for (const Share& each : kShares) {
    json += std::string(comma) + '"' + each.name +
            "\": " + number(1000 * percentile(outcome.latencies, each.share).count());
    comma = ", ";
  }
  json += "}, \"outcomes\": {";
  comma = "";
  for (const auto& [name, count] : outcome.outcomes) {
    json += std::string(comma) + '"' + name + "\": " + std::to_string(count);
    comma = ", ";
  }
  return json + "}}\n";
}

}  // namespace burnish::cli
