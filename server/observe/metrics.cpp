#include "server/observe/metrics.h"

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <iterator>
#include <map>
#include <utility>

#include <prometheus/text_serializer.h>

#include "server/lifecycle.h"
#include "server/observe/process_metrics.h"
#include "server/service/smooth_service.h"
#include "server/status_map.h"

namespace burnish {
namespace {

constexpr std::string_view kOk = "ok";
constexpr Transport kTransports[] = {Transport::Grpc, Transport::Http};
constexpr Kind kKinds[] = {Kind::Smooth, Kind::Compare};
constexpr LifecycleState kStates[] = {LifecycleState::Starting, LifecycleState::Serving,
                                      LifecycleState::Draining, LifecycleState::Stopped};

struct Stage {
  const char* name;
  bool smooth_only;
};
constexpr Stage kStages[] = {{"queue", false}, {"decode", false},  {"prepare", false},
                             {"smooth", true}, {"measure", false}, {"encode", true}};

/// From a small scan to the longest run that is allowed by default.
const prometheus::Histogram::BucketBoundaries kSeconds = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25,
                                                          0.5,   1,      2.5,   5,    10,    30,   60,  600};
/// 1 KiB to 1 GiB in fourfold steps.
const prometheus::Histogram::BucketBoundaries kBytes = {
    1024, 4096, 16384, 65536, 262144, 1048576, 4194304, 16777216, 67108864.0, 268435456., 1073741824.0};

prometheus::ClientMetric labelled(std::string label, std::string_view value, double number) {
  prometheus::ClientMetric metric;
  metric.label = {{std::move(label), std::string(value)}};
  metric.gauge.value = number;
  return metric;
}

prometheus::MetricFamily lifecycle_family(std::string_view now) {
  prometheus::MetricFamily family{"burnish_lifecycle_state",
                                  "1 for the state that the server is in, 0 for the others.",
                                  prometheus::MetricType::Gauge,
                                  {}};
  for (const LifecycleState state : kStates) {
    const std::string_view name = lifecycle_name(state);
    family.metric.push_back(labelled("state", name, name == now ? 1 : 0));
  }
  return family;
}

prometheus::MetricFamily build_info() {
  auto metric = labelled("version", version(), 1);
  metric.label.push_back({"compiler", __VERSION__});
  metric.label.push_back({"grpc_version", grpc::Version()});
  return {
      "burnish_build_info", "Always 1; what runs is in the labels.", prometheus::MetricType::Gauge, {metric}};
}

}  // namespace

std::string_view transport_name(Transport transport) {
  return transport == Transport::Grpc ? "grpc" : "http";
}

std::string_view kind_name(Kind kind) { return kind == Kind::Smooth ? "smooth" : "compare"; }

Metrics::Metrics() {
  add_traffic();
  add_durations();
}

void Metrics::add_traffic() {
  auto& requests = prometheus::BuildCounter()
                       .Name("burnish_requests_total")
                       .Help("Requests to smooth or to compare meshes.")
                       .Register(registry_);
  auto& outcomes = prometheus::BuildCounter()
                       .Name("burnish_outcomes_total")
                       .Help("Ended requests by outcome: ok, or the code of the cause.")
                       .Register(registry_);
  auto& bytes_in = prometheus::BuildHistogram()
                       .Name("burnish_request_mesh_bytes")
                       .Help("Mesh and reference of requests that arrived whole.")
                       .Register(registry_);
  auto& bytes_out = prometheus::BuildHistogram()
                        .Name("burnish_response_mesh_bytes")
                        .Help("Meshes of answers.")
                        .Register(registry_);
  for (const Transport transport : kTransports) {
    for (const Kind kind : kKinds) {
      const std::map<std::string, std::string> labels = {
          {"transport", std::string(transport_name(transport))}, {"kind", std::string(kind_name(kind))}};
      Traffic& counted = traffic(transport, kind);
      counted.requests = &requests.Add(labels);
      counted.bytes_in = &bytes_in.Add(labels, kBytes);
      if (kind == Kind::Smooth) counted.bytes_out = &bytes_out.Add(labels, kBytes);
      const auto add_outcome = [&](std::string_view code) {
        auto with_code = labels;
        with_code.emplace("code", code);
        return &outcomes.Add(with_code);
      };
      counted.ok = add_outcome(kOk);
      for (const Cause cause : all_causes()) {
        counted.refused.push_back(
            add_outcome(cause_code(comes_from_servers(cause) ? cause : Cause::Internal)));
      }
    }
  }
}

void Metrics::add_durations() {
  auto& stages = prometheus::BuildHistogram()
                     .Name("burnish_stage_seconds")
                     .Help("Wall time per stage of answered requests; queue is the wait for a worker.")
                     .Register(registry_);
  auto& totals = prometheus::BuildHistogram()
                     .Name("burnish_job_seconds")
                     .Help("Wall time of answered requests from admission to the answer.")
                     .Register(registry_);
  for (const Kind kind : kKinds) {
    const std::string name(kind_name(kind));
    Durations& timed = durations_[static_cast<std::size_t>(kind)];
    timed.total = &totals.Add({{"kind", name}}, kSeconds);
    for (const Stage& stage : kStages) {
      const bool has = kind == Kind::Smooth || !stage.smooth_only;
      timed.stages.push_back(has ? &stages.Add({{"kind", name}, {"stage", stage.name}}, kSeconds) : nullptr);
    }
  }
}

Metrics::Traffic& Metrics::traffic(Transport transport, Kind kind) {
  return traffic_[static_cast<std::size_t>(transport)][static_cast<std::size_t>(kind)];
}

void Metrics::count_request(Transport transport, Kind kind) {
  traffic(transport, kind).requests->Increment();
}

void Metrics::count_outcome(Transport transport, Kind kind, const Error* error) {
  const Traffic& counted = traffic(transport, kind);
  (error ? counted.refused[static_cast<std::size_t>(error->cause)] : counted.ok)->Increment();
}

void Metrics::observe(Kind kind, const v1::StageTimings& timings) {
  const Durations& timed = durations_[static_cast<std::size_t>(kind)];
  const double milliseconds[] = {timings.queue_ms(),  timings.decode_ms(),  timings.prepare_ms(),
                                 timings.smooth_ms(), timings.measure_ms(), timings.encode_ms()};
  static_assert(std::size(milliseconds) == std::size(kStages));
  for (std::size_t i = 0; i < std::size(kStages); ++i) {
    if (timed.stages[i]) timed.stages[i]->Observe(milliseconds[i] / 1000);
  }
  timed.total->Observe(timings.total_ms() / 1000);
}

void Metrics::count_bytes(Transport transport, Kind kind, std::uint64_t in, std::uint64_t out) {
  const Traffic& counted = traffic(transport, kind);
  if (in > 0) counted.bytes_in->Observe(static_cast<double>(in));
  if (out > 0 && counted.bytes_out) counted.bytes_out->Observe(static_cast<double>(out));
}

void Metrics::record_self_test(bool passed) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  self_test_seconds_ = std::chrono::duration_cast<std::chrono::seconds>(now).count();
  self_test_passed_ = passed;
}

std::string Metrics::text(const Gauges& gauges) const {
  auto families = registry_.Collect();
  const auto add_typed = [&](prometheus::MetricType type, const char* name, const char* help, auto value) {
    families.push_back(single_metric(name, help, type, static_cast<double>(value)));
  };
  const auto add = [&](const char* name, const char* help, auto value) {
    add_typed(prometheus::MetricType::Gauge, name, help, value);
  };
  const auto count = [&](const char* name, const char* help, auto value) {
    add_typed(prometheus::MetricType::Counter, name, help, value);
  };
  add("burnish_queue_depth", "Jobs that wait.", gauges.queued);
  add("burnish_jobs_running", "Jobs that run.", gauges.running);
  add("burnish_workers", "Jobs that can run at once.", gauges.workers);
  add("burnish_reserved_memory_bytes", "Estimated memory of accepted jobs.", gauges.reserved_bytes);
  add("burnish_spooled_bytes", "Bodies of requests that are in the server.", gauges.spooled_bytes);
  add("burnish_kept_jobs_queued", "Kept jobs that wait.", gauges.kept_waiting);
  add("burnish_kept_jobs_running", "Kept jobs that run.", gauges.kept_running);
  count("burnish_result_cache_hits_total", "Kept jobs whose result was there.", gauges.cache_hits);
  count("burnish_result_cache_misses_total", "Kept jobs whose result was not there.", gauges.cache_misses);
  add("burnish_store_bytes", "Meshes, results and uploads on disk.", gauges.store_bytes);
  add("burnish_helper_resident_bytes", "Resident memory of the helper processes.", gauges.helper_bytes);
  count("burnish_helpers_ended_total", "Helper processes that ended and were replaced.",
        gauges.ended_helpers);
  add("burnish_self_test_passed", "1 when the last self-test passed.", self_test_passed_.load() ? 1 : 0);
  add("burnish_self_test_timestamp_seconds", "Unix time of the last self-test; 0: never.",
      self_test_seconds_.load());
  families.push_back(lifecycle_family(gauges.lifecycle));
  families.push_back(build_info());
  for (auto& family : process_metrics()) families.push_back(std::move(family));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace burnish
