#include "server/service/smooth_service.h"

#include <new>
#include <string>

#include "core/measure/error.h"
#include "core/measure/noise_estimate.h"
#include "core/measure/quality.h"
#include "server/service/loaded_mesh.h"
#include "server/service/measures.h"
#include "server/service/options.h"

namespace burnish {
namespace {

/// The request in the order of its life: each stage fills its part of the report.
class Pipeline {
 public:
  Pipeline(const SmoothJob& job, const ResolvedOptions& options, const Limits& limits, const RunControl& run)
      : job_(job), options_(options), limits_(limits), run_(run) {}

  Result<SmoothResult> process() {
    Stopwatch total;
    describe();
    for (const auto stage : {&Pipeline::load, &Pipeline::smooth, &Pipeline::measure, &Pipeline::encode}) {
      if (auto done = (this->*stage)(); !done) return done.error();
    }
    timings().set_queue_ms(job_.queue_ms);
    timings().set_total_ms(job_.queue_ms + total.lap());
    return std::move(result_);
  }

 private:
  void describe() {
    report().set_version(std::string(version()));
    report().set_request_id(job_.request_id);
    report().set_method(options_.method->name);
    for (const auto& [name, value] : options_.parameters.values) {
      (*report().mutable_parameters())[name] = to_proto(value);
    }
  }

  void describe(const NoiseEstimate& noise) {
    report().mutable_noise()->set_sigma_over_edge(noise.sigma_over_edge);
    report().mutable_noise()->set_kind(std::string(name_of(noise.kind)));
  }

  void describe(const MethodChoice& choice) {
    report().mutable_choice()->set_method(choice.method);
    report().mutable_choice()->set_reason(choice.reason);
    report().mutable_choice()->set_sharp_bending(choice.sharp_bending);
    for (const auto& [name, value] : choice.parameters) {
      (*report().mutable_choice()->mutable_parameters())[name] = to_proto(value);
    }
  }

  Result<> load() {
    enter(v1::SMOOTH_STAGE_DECODE);
    auto input = load_mesh(job_.mesh, job_.format, "", limits_, run_, timings());
    if (!input) return std::move(input).error();
    input_ = std::move(*input);
    before_ = input_.surface.mesh.positions;
    warn(input_.warnings());
    input_.summarise(*report().mutable_input());
    if (auto pinned = pin(); !pinned) return pinned;
    if (job_.reference.empty()) return {};
    auto reference =
        load_mesh(job_.reference, job_.reference_format, "reference: ", limits_, run_, timings());
    if (!reference) return std::move(reference).error();
    reference_ = std::move(*reference);
    return {};
  }

  Result<> pin() {
    Stopwatch watch;
    const auto pinned = pin_vertices(*input_.document, options_.pinned, input_.surface, run_);
    if (!pinned) return pinned.error();
    report().set_pinned_vertices(*pinned);
    timings().set_prepare_ms(timings().prepare_ms() + watch.lap());
    return {};
  }

  Result<> smooth() {
    enter(v1::SMOOTH_STAGE_SMOOTH);
    Stopwatch watch;
    RunControl run = run_;
    if (job_.progress) {
      run.progress = [this](double fraction) { job_.progress(v1::SMOOTH_STAGE_SMOOTH, fraction); };
    }
    auto outcome = options_.method->run(input_.surface, options_.parameters, run);
    if (!outcome) return outcome.error();
    warn(outcome->warnings);
    if (outcome->choice) describe(*outcome->choice);
    if (outcome->noise) describe(*outcome->noise);
    timings().set_smooth_ms(watch.lap());
    return {};
  }

  Result<> measure() {
    enter(v1::SMOOTH_STAGE_MEASURE);
    Stopwatch watch;
    const auto& after = input_.surface.mesh.positions;
    const bool own = !reference_.document;
    const bool corresponding = own || same_connectivity(*input_.document, *reference_.document);
    const auto errors = own ? measure_errors(input_.surface, after, input_.surface, before_, true, run_)
                            : measure_errors(input_.surface, after, reference_.surface,
                                             reference_.surface.mesh.positions, corresponding, run_);
    if (!errors) return errors.error();
    fill(*errors, own ? "input" : "reference", *report().mutable_errors());
    const auto change = measure_change(input_.surface, before_, after, run_);
    if (!change) return change.error();
    fill(*change, *report().mutable_change());
    if (!report().has_noise()) describe(estimate_noise(input_.surface, before_, run_));
    if (run_.stopped()) return run_.stop_error();
    if (!corresponding) warn({connectivity_differs()});
    timings().set_measure_ms(watch.lap());
    return {};
  }

  Result<> encode() {
    enter(v1::SMOOTH_STAGE_ENCODE);
    Stopwatch watch;
    const MovedPositions moved{input_.document->positions(), input_.surface.weld, before_,
                               input_.surface.mesh.positions, input_.surface.mesh.frame};
    auto encoded = burnish::encode(*input_.document, moved, options_.output, run_);
    if (!encoded) return encoded.error();
    result_.format = options_.output.format.value_or(input_.document->format());
    input_.summarise(*report().mutable_output());
    if (encoded->vertices) report().mutable_output()->set_vertices(*encoded->vertices);
    if (encoded->triangles) report().mutable_output()->set_triangles(*encoded->triangles);
    fill(*encoded, result_.format, *report().mutable_encoding());
    result_.mesh = std::move(encoded->bytes);
    warn(encoded->warnings);
    timings().set_encode_ms(watch.lap());
    return {};
  }

  void enter(v1::SmoothStage stage) const {
    if (job_.progress) job_.progress(stage, 0);
  }

  void warn(const std::vector<Warning>& warnings) { add_warnings(warnings, *report().mutable_warnings()); }

  v1::SmoothReport& report() { return result_.report; }
  v1::StageTimings& timings() { return *result_.report.mutable_timings(); }

  const SmoothJob& job_;
  const ResolvedOptions& options_;
  const Limits& limits_;
  const RunControl& run_;
  LoadedMesh input_, reference_;
  std::vector<Vec3f> before_;
  SmoothResult result_;
};

}  // namespace

Result<> SmoothService::check_size(std::uint64_t bytes, std::string_view what) const {
  if (bytes <= limits_.mesh.max_bytes) return {};
  return Error{Cause::TooLarge, std::string(what) + " has " + std::to_string(bytes) +
                                    " bytes; the limit is " + std::to_string(limits_.mesh.max_bytes) +
                                    " (max-bytes)"};
}

Result<> SmoothService::check(const v1::SmoothOptions& options) const {
  if (const std::size_t bytes = options.ByteSizeLong(); bytes > limits_.max_option_bytes) {
    return Error{Cause::TooLarge, "the options have " + std::to_string(bytes) + " bytes; the limit is " +
                                      std::to_string(limits_.max_option_bytes) + " (max-option-bytes)"};
  }
  const auto resolved = resolve_options(options);
  if (!resolved) return resolved.error();
  const auto iterations = resolved->parameters.values.find("iterations");
  if (iterations != resolved->parameters.values.end() &&
      std::get<std::int64_t>(iterations->second) > limits_.max_iterations) {
    return Error{Cause::BadOption,
                 "iterations is " + std::to_string(std::get<std::int64_t>(iterations->second)) +
                     "; the limit is " + std::to_string(limits_.max_iterations) + " (max-iterations)",
                 "iterations"};
  }
  return {};
}

Result<> SmoothService::check(const SmoothJob& job) const {
  if (job.mesh.empty()) return Error{Cause::EmptyMesh, "the mesh has no bytes"};
  if (auto fits = check_size(job.mesh.size(), "the mesh"); !fits) return fits;
  if (auto fits = check_size(job.reference.size(), "the reference"); !fits) return fits;
  return check(job.options);
}

Result<SmoothResult> SmoothService::smooth(const SmoothJob& job, const RunControl& run) const {
  try {
    if (auto fine = check(job); !fine) return fine.error();
    const auto options = resolve_options(job.options);
    return Pipeline(job, *options, limits_.mesh, run).process();
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "the mesh needs more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{Cause::Internal, std::string("unexpected failure: ") + failure.what()};
  }
}

std::string_view version() { return BURNISH_VERSION; }

}  // namespace burnish
