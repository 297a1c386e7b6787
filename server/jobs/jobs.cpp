#include "server/jobs/jobs.h"

#include <exception>
#include <future>
#include <new>
#include <random>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/io/estimate.h"
#include "core/smooth/registry.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

constexpr std::chrono::seconds kSelfTestPatience{30};
constexpr const char* kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

// Rough seconds on one core of a small machine, beside the smoothing; Pace learns how far off they are here.
constexpr double kPerJob = 5e-4, kPerTriangle = 1e-6;

std::optional<double> iterations_of(const v1::SmoothOptions& options) {
  if (options.has_iterations()) return options.iterations();
  const auto given = options.parameters().find("iterations");
  return given == options.parameters().end() ? std::nullopt : std::optional(given->second.number_value());
}

/// `bytes`: of the files; `smoothing_bytes`, `smoothing_seconds`: what the method takes beside the rest.
JobCost cost_of(const Estimate& mesh, const Estimate& reference, std::uint64_t bytes,
                std::uint64_t smoothing_bytes, double smoothing_seconds) {
  const auto both = static_cast<double>(mesh.triangles) + static_cast<double>(reference.triangles);
  return {.bytes = bytes + mesh.memory_with(smoothing_bytes) + reference.memory_bytes,
          .work = kPerJob + kPerTriangle * both + smoothing_seconds};
}

Estimate estimate_if_any(std::string_view bytes, std::optional<Format> format) {
  return bytes.empty() ? Estimate() : estimate(bytes, format);
}

JobCost cost_of(const SmoothJob& job) {
  const Estimate mesh = estimate(job.mesh, job.format);
  const std::string& method = job.options.method();
  return cost_of(mesh, estimate_if_any(job.reference, job.reference_format),
                 job.mesh.size() + job.reference.size(),
                 work_memory_of(method).bytes(mesh.vertices, mesh.triangles),
                 seconds_of(method, mesh.triangles, iterations_of(job.options)));
}

JobCost cost_of(const CompareJob& job) {
  return cost_of(estimate(job.mesh, job.format), estimate(job.reference, job.reference_format),
                 job.mesh.size() + job.reference.size(), 0, 0);
}

Kind kind_of(const SmoothJob&) { return Kind::Smooth; }
Kind kind_of(const CompareJob&) { return Kind::Compare; }

/// What ran; before it ran, what was asked for.
std::string_view method_of(const SmoothJob& job, const SmoothResult* result) {
  return result ? result->report.method() : job.options.method();
}
std::string_view method_of(const CompareJob&, const v1::CompareResponse*) { return "compare"; }

const v1::MeshSummary& summary_of(const SmoothResult& result) { return result.report.input(); }
const v1::MeshSummary& summary_of(const v1::CompareResponse& response) { return response.mesh(); }

const v1::StageTimings& timings_of(const SmoothResult& result) { return result.report.timings(); }
const v1::StageTimings& timings_of(const v1::CompareResponse& response) { return response.timings(); }

std::size_t bytes_out(const SmoothResult& result) { return result.mesh.size(); }
std::size_t bytes_out(const v1::CompareResponse&) { return 0; }

std::string trace_field(const std::string& trace_id) { return trace_id.empty() ? "" : " trace=" + trace_id; }

}  // namespace

std::string new_request_id() {
  thread_local std::random_device random;  // opening it takes as long as ten numbers
  return fmt::format("{:08x}{:08x}", random(), random());
}

template <class Job, class Answer>
struct Jobs::Call {
  Caller caller;
  Job job;
  Done<Answer> done;
  Clock::time_point arrived = Clock::now();
};

Jobs::Jobs(const SmoothService& service, JobRunner& runner, Spool& spool, const Lifecycle& lifecycle,
           Metrics& metrics, SmoothFunction smooth, CompareFunction compare)
    : service_(service),
      runner_(runner),
      spool_(spool),
      lifecycle_(lifecycle),
      metrics_(metrics),
      smooth_(std::move(smooth)),
      compare_(std::move(compare)) {}

std::string Jobs::new_kept_id() const {
  return (replica_.empty() ? "" : replica_ + "-") + new_request_id() + new_request_id();
}

std::optional<JobHandle> Jobs::smooth(const Caller& caller, SmoothJob job, Done<SmoothResult> done) {
  return submit(caller, std::move(job), std::move(done));
}

std::optional<JobHandle> Jobs::compare(const Caller& caller, CompareJob job, Done<v1::CompareResponse> done) {
  return submit(caller, std::move(job), std::move(done));
}

template <class Job, class Answer>
std::optional<JobHandle> Jobs::submit(const Caller& caller, Job job, Done<Answer> done) {
  using TheCall = Call<Job, Answer>;
  job.request_id = caller.request_id;
  auto call = std::make_shared<TheCall>(TheCall{caller, std::move(job), std::move(done)});
  metrics_.count_request(caller.transport, kind_of(call->job));
  if (auto admitted = admit(caller, call->job); !admitted) {
    finish(*call, Result<Answer>(std::move(admitted).error()));
    return {};
  }
  auto handle = runner_.submit(
      {.run = [this, call](const RunControl& control, double queue_ms) { run(*call, control, queue_ms); },
       .refuse = [this, call](const Error& error) { finish(*call, Result<Answer>(error)); },
       .turn = {caller.owner, caller.low},
       .kept = caller.kept},
      cost_of(call->job), caller.deadline);
  if (!handle) {
    finish(*call, Result<Answer>(std::move(handle).error()));
    return {};
  }
  return *handle;
}

template <class Job>
Result<> Jobs::admit(const Caller& caller, const Job& job) const {
  if (!lifecycle_.serving()) return Error{Cause::ShuttingDown, "the server does not take work now"};
  if (caller.refusal) return *caller.refusal;
  if (auto fine = service_.check(job); !fine) return fine;
  if (caller.kept) return {};  // paid for when it was accepted
  // A full queue is told before anything is paid, and before the mesh is looked at.
  if (auto place = runner_.would_take({}, caller.deadline, {caller.owner, caller.low}); !place) return place;
  const std::uint64_t bytes = job.mesh.size() + job.reference.size();
  return charge(caller, bytes, bytes);
}

void Jobs::identify(std::string_view authorization, Caller& caller, bool counts) const {
  if (!tokens_) return;
  auto identity = tokens_->identify(authorization, counts);
  if (!identity) {
    caller.refusal = std::move(identity).error();
    return;
  }
  caller.owner = identity->owner;
  caller.quota = identity->quota;
}

Result<> Jobs::charge(const Caller& caller, std::uint64_t bytes, std::uint64_t whole) const {
  if (caller.refusal) return *caller.refusal;
  if (!tokens_) return {};
  if (caller.quota.max_bytes > 0 && whole > caller.quota.max_bytes) {
    return Error{Cause::QuotaExceeded, fmt::format("the meshes have {} bytes; the token allows {} (maxBytes)",
                                                   whole, caller.quota.max_bytes)};
  }
  return tokens_->charge(caller.owner, bytes);
}

Result<> Jobs::expect(const Caller& caller, std::uint64_t mesh_bytes, std::uint64_t reference_bytes) const {
  if (!lifecycle_.serving()) return Error{Cause::ShuttingDown, "the server does not take work now"};
  if (caller.refusal) return *caller.refusal;
  if (auto fits = service_.check_size(mesh_bytes, "the mesh"); !fits) return fits;
  if (auto fits = service_.check_size(reference_bytes, "the reference"); !fits) return fits;
  // Without a word about the format the cheaper one counts, so that nothing is refused that would fit.
  const std::uint64_t bytes = mesh_bytes + reference_bytes;
  return runner_.would_take({.bytes = bytes + estimate(bytes, Format::Obj).memory_bytes}, caller.deadline,
                            {caller.owner, caller.low});
}

Result<> Jobs::would_take(const Caller& caller, const SmoothJob& job) const {
  return runner_.would_take(cost_of(job), caller.deadline, {caller.owner, caller.low}, caller.kept);
}

std::chrono::duration<double> Jobs::expected_seconds(const SmoothJob& job) const {
  return runner_.expected_seconds(cost_of(job).work);
}

template <class Job, class Answer>
void Jobs::run(Call<Job, Answer>& call, const RunControl& control, double queue_ms) {
  call.job.queue_ms = queue_ms;
  Result<Answer> result = perform(call.job, control);
  if (!result && result.error().cause == Cause::Cancelled && !lifecycle_.serving()) {
    result = Error{Cause::ShuttingDown, "the server shut down before the job was done"};
  }
  finish(call, std::move(result));
}

/// No exception may keep a caller waiting for an answer.
Result<SmoothResult> Jobs::perform(const SmoothJob& job, const RunControl& run) const {
  try {
    return smooth_ ? smooth_(job, run) : service_.smooth(job, run);
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "not enough memory for this mesh"};
  } catch (const std::exception& e) {
    return Error{Cause::Internal, e.what()};
  }
}

Result<v1::CompareResponse> Jobs::perform(const CompareJob& job, const RunControl& run) const {
  return compare_ ? compare_(job, run) : service_.compare(job, run);
}

template <class Job, class Answer>
void Jobs::finish(Call<Job, Answer>& call, Result<Answer> result) {
  const Job& job = call.job;
  const Kind kind = kind_of(job);
  const Transport transport = call.caller.transport;
  const std::uint64_t in = job.mesh.size() + job.reference.size();
  const std::uint64_t out = result ? bytes_out(*result) : 0;
  if (!result) {
    Error error = std::move(result).error();
    error.message = printable(error.message);
    error.field = printable(error.field, 100);
    result = std::move(error);
  }
  const Error* const error = result ? nullptr : &result.error();
  const v1::MeshSummary input = result ? summary_of(*result) : v1::MeshSummary();
  const std::chrono::duration<double, std::milli> total = Clock::now() - call.arrived;
  spdlog::info(
      "request id={}{} transport={} method={} bytes_in={} bytes_out={} vertices={} triangles={} outcome={} "
      "total_ms={:.1f} queue_ms={:.1f}{}{}",
      call.caller.request_id, trace_field(call.caller.trace_id), transport_name(transport),
      printable(method_of(job, result ? &*result : nullptr), 40), in, out, input.vertices(),
      input.triangles(), error ? cause_code(error->cause) : "ok", total.count(), job.queue_ms,
      error ? " detail=" : "", error ? error->message : "");
  if (result) metrics_.observe(kind, timings_of(*result));
  metrics_.count_bytes(transport, kind, in, out);
  metrics_.count_outcome(transport, kind, error);
  call.done(std::move(result));
}

void Jobs::record_refusal(const Caller& caller, const Error& error) {
  metrics_.count_request(caller.transport, caller.kind);
  metrics_.count_outcome(caller.transport, caller.kind, &error);
  spdlog::info("request id={}{} transport={} outcome={} detail={}", caller.request_id,
               trace_field(caller.trace_id), transport_name(caller.transport), cause_code(error.cause),
               printable(error.message));
}

Result<> Jobs::self_test() {
  const auto ended = std::make_shared<std::promise<Result<>>>();
  auto outcome = ended->get_future();
  const auto run = [this, ended](const RunControl& control, double) {
    auto smoothed = service_.smooth({.mesh = kTetrahedron, .request_id = "self-test"}, control);
    ended->set_value(smoothed ? Result<>() : std::move(smoothed).error());
  };
  const auto refuse = [ended](const Error& error) { ended->set_value(error); };
  Result<> result = Error{Cause::Internal, "no worker took the self-test"};
  if (auto handle = runner_.submit({run, refuse}, {}, {}); !handle) {
    result = std::move(handle).error();
  } else if (outcome.wait_for(kSelfTestPatience) == std::future_status::ready) {
    result = outcome.get();
  }
  metrics_.record_self_test(result.ok());
  return result;
}

std::string Jobs::metrics_text() {
  Gauges gauges{.queued = runner_.queued(),
                .running = runner_.running(),
                .workers = runner_.workers(),
                .reserved_bytes = runner_.reserved_bytes(),
                .spooled_bytes = spool_.bytes(),
                .lifecycle = lifecycle_name(lifecycle_.state())};
  more_gauges_(gauges);
  return metrics_.text(gauges);
}

}  // namespace burnish
