// What the server counts, for GET /metrics.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "burnish/v1/smoothing.pb.h"
#include "core/run/error.h"

namespace burnish {

enum class Transport : std::uint8_t { Grpc, Http };
std::string_view transport_name(Transport transport);  ///< "grpc", "http"

/// Requests to smooth, how they ended, and how long their stages took. Thread-safe. Every series exists from
/// the start, so rates are right from the first event on.
class Metrics {
 public:
  Metrics();

  void count_request(Transport transport);
  /// `error` null: the request was answered with a mesh.
  void count_outcome(Transport transport, const Error* error);
  void observe(const v1::StageTimings& timings);

  /// Prometheus text format 0.0.4, with the two gauges as given.
  std::string text(std::size_t queued, std::size_t running);

 private:
  prometheus::Registry registry_;
  std::map<Transport, prometheus::Counter*> requests_;
  std::map<std::pair<Transport, std::string_view>, prometheus::Counter*> outcomes_;
  std::map<std::string_view, prometheus::Histogram*> stages_;
  prometheus::Gauge* queue_depth_;
  prometheus::Gauge* jobs_running_;
};

}  // namespace burnish
