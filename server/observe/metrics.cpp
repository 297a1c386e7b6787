#include "server/observe/metrics.h"

#include <utility>

#include <prometheus/text_serializer.h>

namespace burnish {
namespace {

constexpr std::string_view kOk = "ok";
constexpr Transport kTransports[] = {Transport::Grpc, Transport::Http};
constexpr std::string_view kStages[] = {"queue", "decode", "prepare", "smooth", "measure", "encode", "total"};

/// From a small scan to the longest run that is allowed by default.
const prometheus::Histogram::BucketBoundaries kSeconds = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25,
                                                          0.5,   1,      2.5,   5,    10,    30,   60,  600};

}  // namespace

std::string_view transport_name(Transport transport) {
  return transport == Transport::Grpc ? "grpc" : "http";
}

Metrics::Metrics() {
  auto& requests = prometheus::BuildCounter()
                       .Name("burnish_requests_total")
                       .Help("Requests to smooth a mesh.")
                       .Register(registry_);
  auto& outcomes = prometheus::BuildCounter()
                       .Name("burnish_outcomes_total")
                       .Help("Ended requests by outcome: ok, or the code of the cause.")
                       .Register(registry_);
  for (const Transport transport : kTransports) {
    const std::string name(transport_name(transport));
    requests_[transport] = &requests.Add({{"transport", name}});
    const auto add_outcome = [&](std::string_view code) {
      outcomes_[{transport, code}] = &outcomes.Add({{"transport", name}, {"code", std::string(code)}});
    };
    add_outcome(kOk);
    for (const Cause cause : all_causes()) add_outcome(cause_code(cause));
  }
  auto& stages = prometheus::BuildHistogram()
                     .Name("burnish_stage_seconds")
                     .Help("Wall time per stage of answered requests.")
                     .Register(registry_);
  for (const std::string_view stage : kStages) {
    stages_[stage] = &stages.Add({{"stage", std::string(stage)}}, kSeconds);
  }
  queue_depth_ = &prometheus::BuildGauge()
                      .Name("burnish_queue_depth")
                      .Help("Jobs that wait.")
                      .Register(registry_)
                      .Add({});
  jobs_running_ = &prometheus::BuildGauge()
                       .Name("burnish_jobs_running")
                       .Help("Jobs that run.")
                       .Register(registry_)
                       .Add({});
}

void Metrics::count_request(Transport transport) { requests_.at(transport)->Increment(); }

void Metrics::count_outcome(Transport transport, const Error* error) {
  outcomes_.at({transport, error ? cause_code(error->cause) : kOk})->Increment();
}

void Metrics::observe(const v1::StageTimings& timings) {
  const double milliseconds[] = {timings.queue_ms(),  timings.decode_ms(),  timings.prepare_ms(),
                                 timings.smooth_ms(), timings.measure_ms(), timings.encode_ms(),
                                 timings.total_ms()};
  for (std::size_t i = 0; i < std::size(kStages); ++i)
    stages_.at(kStages[i])->Observe(milliseconds[i] / 1000);
}

std::string Metrics::text(std::size_t queued, std::size_t running) {
  queue_depth_->Set(static_cast<double>(queued));
  jobs_running_->Set(static_cast<double>(running));
  return prometheus::TextSerializer().Serialize(registry_.Collect());
}

}  // namespace burnish
