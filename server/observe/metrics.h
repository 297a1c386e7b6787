// What the server counts, for GET /metrics. docs/operations.md lists every metric.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "burnish/v1/smoothing.pb.h"
#include "core/run/error.h"

namespace burnish {

enum class Transport : std::uint8_t { Grpc, Http };
std::string_view transport_name(Transport transport);  ///< "grpc", "http"

enum class Kind : std::uint8_t { Smooth, Compare };
std::string_view kind_name(Kind kind);  ///< "smooth", "compare"

/// What others know at the moment of asking.
struct Gauges {
  std::size_t queued = 0, running = 0, workers = 0;
  std::uint64_t reserved_bytes = 0;                ///< estimated memory of accepted jobs
  std::uint64_t spooled_bytes = 0;                 ///< of request bodies
  std::string_view lifecycle = {};                 ///< as lifecycle_name() says it
  std::size_t kept_waiting = 0, kept_running = 0;  ///< jobs that outlive their call
  std::uint64_t cache_hits = 0, cache_misses = 0;  ///< of their results
  std::uint64_t store_bytes = 0;                   ///< of meshes, results and uploads on disk
  std::uint64_t helper_bytes = 0;                  ///< resident, of all helper processes
  std::uint64_t ended_helpers = 0;                 ///< that had to be replaced
};

/// Requests, how they ended, how long their stages took and how large they were. Thread-safe; counting takes
/// no lookup and no allocation. Every series exists from the start, so rates are right from the first event
/// on.
class Metrics {
 public:
  Metrics();

  void count_request(Transport transport, Kind kind);
  /// `error` null: the request was answered.
  void count_outcome(Transport transport, Kind kind, const Error* error);
  void observe(Kind kind, const v1::StageTimings& timings);
  /// Mesh bytes that came and went; 0: none.
  void count_bytes(Transport transport, Kind kind, std::uint64_t in, std::uint64_t out);
  void record_self_test(bool passed);

  /// Prometheus text format 0.0.4.
  std::string text(const Gauges& gauges) const;

 private:
  /// Of one kind of request over one transport.
  struct Traffic {
    prometheus::Counter* requests = nullptr;
    prometheus::Counter* ok = nullptr;
    std::vector<prometheus::Counter*> refused;  ///< by Cause
    prometheus::Histogram* bytes_in = nullptr;
    prometheus::Histogram* bytes_out = nullptr;  ///< null when the answer holds no mesh
  };
  /// Of one kind of request.
  struct Durations {
    std::vector<prometheus::Histogram*> stages;  ///< null where the kind has no such stage
    prometheus::Histogram* total = nullptr;
  };
  Traffic& traffic(Transport transport, Kind kind);
  void add_traffic();
  void add_durations();

  prometheus::Registry registry_;
  std::array<std::array<Traffic, 2>, 2> traffic_;  ///< by Transport, then Kind
  std::array<Durations, 2> durations_;             ///< by Kind
  std::atomic<bool> self_test_passed_ = false;
  std::atomic<std::int64_t> self_test_seconds_ = 0;  ///< when, in Unix time; 0: never
};

}  // namespace burnish
