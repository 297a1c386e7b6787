// Load on a server: calls that are due at fixed times, and what became of them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <stop_token>
#include <string>
#include <vector>

namespace burnish::cli {

struct LoadOptions {
  unsigned concurrency = 1;  ///< calls at once
  double rate = 0;  ///< calls that are due a second, together; 0: the next as soon as one is answered
  std::chrono::duration<double> duration{10};
};

struct LoadOutcome {
  /// Of answered calls, from when each was due: a call that waits because those before it are late is late
  /// itself, which a clock that starts with the call would not see (coordinated omission). Ascending.
  std::vector<std::chrono::duration<double>> latencies;
  std::map<std::string, std::uint64_t> outcomes;  ///< calls by "ok" or the cause of their error
  std::uint64_t unsent = 0;                       ///< calls that were due and for which nobody was free
  std::chrono::duration<double> took{};

  std::uint64_t calls() const;
};

/// Calls call() from options.concurrency threads; it gives "ok" or a cause. Ends early when stopped.
LoadOutcome load(const LoadOptions& options, const std::function<std::string()>& call,
                 const std::stop_token& stop);

/// The least value that so much of the ascending values, 0 to 1, do not exceed; 0 of none.
std::chrono::duration<double> percentile(const std::vector<std::chrono::duration<double>>& ascending,
                                         double share);

void print_load(std::ostream& out, const LoadOutcome& outcome);
std::string load_json(const LoadOutcome& outcome);

}  // namespace burnish::cli
