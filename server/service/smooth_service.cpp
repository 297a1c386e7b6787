#include "server/service/smooth_service.h"

#include <algorithm>
#include <new>

#include "core/measure/error.h"
#include "core/measure/quality.h"
#include "server/service/measures.h"
#include "server/service/options.h"

namespace burnish {
namespace {

class Stopwatch {
 public:
  /// Milliseconds since the last call, or since construction.
  double lap() {
    const auto now = RunControl::Clock::now();
    const std::chrono::duration<double, std::milli> passed = now - start_;
    start_ = now;
    return passed.count();
  }

 private:
  RunControl::Clock::time_point start_ = RunControl::Clock::now();
};

struct LoadedMesh {
  std::unique_ptr<Document> document;
  Surface surface;
};

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

  Result<> load() {
    if (auto loaded = load_one(job_.mesh, job_.format, input_); !loaded) return loaded;
    before_ = input_.surface.mesh.positions;
    const Document& document = *input_.document;
    add_warnings(surface_warnings(
        input_.surface, [&](Index v) { return document.vertex_place(v); },
        [&](Index t) { return document.triangle_place(t); }));
    summarise(*report().mutable_input());
    if (job_.reference.empty()) return {};
    auto loaded = load_one(job_.reference, job_.reference_format, reference_);
    if (loaded) return {};
    Error error = loaded.error();
    error.message = "reference: " + error.message;
    return error;
  }

  Result<> load_one(std::string_view bytes, std::optional<Format> format, LoadedMesh& mesh) {
    Stopwatch watch;
    auto document = decode(bytes, format, limits_, run_);
    timings().set_decode_ms(timings().decode_ms() + watch.lap());
    if (!document) return document.error();
    mesh.document = std::move(*document);
    auto surface = prepare_surface(mesh.document->positions(), mesh.document->triangles(), run_);
    timings().set_prepare_ms(timings().prepare_ms() + watch.lap());
    if (!surface) return surface.error();
    mesh.surface = std::move(*surface);
    return {};
  }

  Result<> smooth() {
    Stopwatch watch;
    auto outcome = options_.method->run(input_.surface, options_.parameters, run_);
    if (!outcome) return outcome.error();
    add_warnings(outcome->warnings);
    timings().set_smooth_ms(watch.lap());
    return {};
  }

  Result<> measure() {
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
    if (!corresponding) {
      add_warnings(
          {{"connectivity_differs", "the reference has other triangles, so normals were not compared", 1}});
    }
    timings().set_measure_ms(watch.lap());
    return {};
  }

  Result<> encode() {
    Stopwatch watch;
    const MovedPositions moved{input_.document->positions(), input_.surface.weld, before_,
                               input_.surface.mesh.positions, input_.surface.mesh.frame};
    auto encoded = burnish::encode(*input_.document, moved, options_.output, run_);
    if (!encoded) return encoded.error();
    result_.mesh = std::move(encoded->bytes);
    result_.format = options_.output.format.value_or(input_.document->format());
    summarise(*report().mutable_output());
    if (encoded->vertices) report().mutable_output()->set_vertices(*encoded->vertices);
    if (encoded->triangles) report().mutable_output()->set_triangles(*encoded->triangles);
    fill(*encoded, result_.format, *report().mutable_encoding());
    add_warnings(encoded->warnings);
    timings().set_encode_ms(watch.lap());
    return {};
  }

  void summarise(v1::MeshSummary& summary) const {
    summary.set_vertices(static_cast<std::uint32_t>(input_.document->positions().size()));
    summary.set_triangles(static_cast<std::uint32_t>(input_.document->triangles().size()));
    summary.set_boundary_edges(input_.surface.topology.boundary_edges);
    summary.set_components(input_.surface.topology.components);
  }

  void add_warnings(const std::vector<Warning>& warnings) {
    for (const Warning& warning : warnings) {
      v1::ReportWarning& out = *report().add_warnings();
      out.set_code(warning.code);
      out.set_message(warning.message);
      out.set_count(warning.count);
    }
  }

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

Result<> check_size(std::string_view bytes, const char* what, const Limits& limits) {
  if (bytes.size() <= limits.max_bytes) return {};
  return Error{Cause::TooLarge, std::string(what) + " has " + std::to_string(bytes.size()) +
                                    " bytes; the limit is " + std::to_string(limits.max_bytes)};
}

}  // namespace

Result<> SmoothService::check(const SmoothJob& job) const {
  if (job.mesh.empty()) return Error{Cause::EmptyMesh, "the mesh has no bytes"};
  if (auto fits = check_size(job.mesh, "the mesh", limits_); !fits) return fits;
  if (auto fits = check_size(job.reference, "the reference", limits_); !fits) return fits;
  if (auto options = resolve_options(job.options); !options) return options.error();
  return {};
}

Result<SmoothResult> SmoothService::smooth(const SmoothJob& job, const RunControl& run) const {
  try {
    if (auto fine = check(job); !fine) return fine.error();
    const auto options = resolve_options(job.options);
    return Pipeline(job, *options, limits_, run).process();
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "the mesh needs more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{Cause::Internal, std::string("unexpected failure: ") + failure.what()};
  }
}

std::string_view version() { return BURNISH_VERSION; }

}  // namespace burnish
