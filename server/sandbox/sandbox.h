// Helper processes that decode, smooth and encode, so that foreign bytes never reach the process that holds
// the port, the keys and the other callers' meshes: a mesh that ends its decoder ends one helper, one job,
// and nothing else.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/service/smooth_service.h"

namespace burnish {

class HelperProcess;

struct SandboxOptions {
  std::string program;  ///< that calls run_helper() when its only argument is kHelperArgument
  RequestLimits limits = {};
  unsigned helpers = 1;          ///< started ahead; one for each job that runs at once
  std::uint64_t max_memory = 0;  ///< bytes of its own that a helper may have; 0 = any
  /// A helper that works on for so long after its job was to stop is killed.
  std::chrono::milliseconds patience{1000};
};

/// Thread-safe. Results are those of SmoothService, byte for byte.
class Sandbox {
 public:
  /// Errors: Internal when no helper comes up, naming the reason.
  static Result<std::unique_ptr<Sandbox>> start(const SandboxOptions& options);
  ~Sandbox();  ///< nobody may be in smooth() or compare() any more

  /// Errors: those of SmoothService; OutOfMemory for a helper that the system killed, Internal for one that
  /// ended.
  Result<SmoothResult> smooth(const SmoothJob& job, const RunControl& run);
  Result<v1::CompareResponse> compare(const CompareJob& job, const RunControl& run);

  std::uint64_t ended_helpers() const { return ended_; }  ///< that had to be replaced
  std::uint64_t resident_bytes() const;                   ///< of all helpers
  std::vector<int> helper_ids() const;                    ///< of processes that live

 private:
  struct Exchange;
  using HelperPtr = std::shared_ptr<HelperProcess>;

  explicit Sandbox(SandboxOptions options) : options_(std::move(options)) {}
  Result<HelperPtr> new_helper();
  Result<HelperPtr> take();
  void give_back(const HelperPtr& helper);
  Error lose(const HelperPtr& helper);
  std::uint64_t new_job() { return ++jobs_; }
  Result<> perform(Exchange& exchange, const RunControl& run);
  Result<> hand_over(Exchange& exchange, HelperProcess& helper, const RunControl& run) const;
  Result<> await_end(Exchange& exchange, const HelperPtr& helper, const RunControl& run);

  const SandboxOptions options_;
  std::atomic<std::uint64_t> ended_ = 0, jobs_ = 0;
  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable came_back_;
  std::vector<HelperPtr> idle_, all_;
  unsigned missing_ = 0;  ///< helpers that ended and were not started again
};

}  // namespace burnish
