#include "server/jobs/smooth_jobs.h"

#include <algorithm>
#include <exception>
#include <new>
#include <random>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/observe/log.h"

namespace burnish {

std::string new_request_id() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

struct SmoothJobs::Call {
  Transport transport;
  SmoothJob job;
  Done done;
  Clock::time_point arrived = Clock::now();
};

SmoothJobs::SmoothJobs(const SmoothService& service, JobRunner& runner, const Lifecycle& lifecycle,
                       Metrics& metrics, std::chrono::milliseconds longest_run, SmoothFunction smooth)
    : service_(service),
      runner_(runner),
      lifecycle_(lifecycle),
      metrics_(metrics),
      longest_run_(longest_run),
      smooth_(std::move(smooth)) {}

std::optional<JobHandle> SmoothJobs::submit(Transport transport, SmoothJob job,
                                            std::optional<Clock::time_point> deadline, Done done) {
  auto call = std::make_shared<Call>(Call{transport, std::move(job), std::move(done)});
  metrics_.count_request(transport);
  if (auto admitted = admit(call->job); !admitted) {
    finish(*call, std::move(admitted).error());
    return {};
  }
  auto handle = runner_.submit(
      {.run = [this, call](const RunControl& control, double queue_ms) { run(*call, control, queue_ms); },
       .refuse = [this, call](const Error& error) { finish(*call, error); }},
      deadline);
  if (!handle) {
    finish(*call, std::move(handle).error());
    return {};
  }
  return *handle;
}

Result<> SmoothJobs::admit(const SmoothJob& job) const {
  if (!lifecycle_.serving()) return Error{Cause::ShuttingDown, "the server is shutting down"};
  return service_.check(job);
}

void SmoothJobs::run(Call& call, const RunControl& control, double queue_ms) {
  RunControl bounded = control;
  const auto limit = Clock::now() + longest_run_;
  bounded.deadline = std::min(control.deadline.value_or(limit), limit);
  call.job.queue_ms = queue_ms;
  Result<SmoothResult> result = smooth(call.job, bounded);
  if (!result && result.error().cause == Cause::Cancelled && !lifecycle_.serving()) {
    result = Error{Cause::ShuttingDown, "the server shut down before the job was done"};
  }
  finish(call, std::move(result));
}

/// No exception may keep a caller waiting for an answer.
Result<SmoothResult> SmoothJobs::smooth(const SmoothJob& job, const RunControl& run) const {
  try {
    return smooth_ ? smooth_(job, run) : service_.smooth(job, run);
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "not enough memory for this mesh"};
  } catch (const std::exception& e) {
    return Error{Cause::Internal, e.what()};
  }
}

void SmoothJobs::finish(Call& call, Result<SmoothResult> result) {
  const std::chrono::duration<double, std::milli> total = Clock::now() - call.arrived;
  const SmoothJob& job = call.job;
  const auto log = [&](std::string_view method, std::string_view outcome, std::size_t bytes_out,
                       const v1::MeshSummary& input, std::string_view detail) {
    spdlog::info(
        "request id={} transport={} method={} bytes_in={} bytes_out={} vertices={} triangles={} outcome={} "
        "total_ms={:.1f} queue_ms={:.1f}{}{}",
        job.request_id, transport_name(call.transport), printable(method, 40),
        job.mesh.size() + job.reference.size(), bytes_out, input.vertices(), input.triangles(), outcome,
        total.count(), job.queue_ms, detail.empty() ? "" : " detail=", detail);
  };
  if (result) {
    log(result->report.method(), "ok", result->mesh.size(), result->report.input(), "");
    metrics_.observe(result->report.timings());
    metrics_.count_outcome(call.transport, nullptr);
    call.done(std::move(result));
  } else {
    Error error = std::move(result).error();
    error.message = printable(error.message);
    error.field = printable(error.field, 100);
    log(job.options.method(), cause_code(error.cause), 0, {}, error.message);
    metrics_.count_outcome(call.transport, &error);
    call.done(std::move(error));
  }
}

void SmoothJobs::record_refusal(Transport transport, std::string_view request_id, const Error& error) {
  metrics_.count_request(transport);
  metrics_.count_outcome(transport, &error);
  spdlog::info("request id={} transport={} outcome={} detail={}", request_id, transport_name(transport),
               cause_code(error.cause), printable(error.message));
}

}  // namespace burnish
