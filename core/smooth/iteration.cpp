#include "core/smooth/iteration.h"

#include <algorithm>
#include <atomic>

#include "core/run/buffer.h"
#include "core/run/parallel.h"
#include "core/smooth/volume.h"

namespace burnish {
std::vector<ParameterSpec> iteration_parameters() {
  const IterationOptions defaults;
  return {
      {.name = "iterations",
       .kind = ParameterKind::Integer,
       .default_value = std::int64_t{defaults.iterations},
       .minimum = 0,
       .maximum = kMostIterations,
       .unit = "1",
       .text = "How often the step is repeated."},
      {.name = "boundary",
       .kind = ParameterKind::Choice,
       .default_value = std::string("fixed"),
       .choices = {"fixed", "free"},
       .text = "Whether vertices on open edges stay in place or move as well."},
      {.name = "max_displacement",
       .default_value = 0.0,
       .minimum = 0,
       .maximum = 1e9,
       .unit = "max_displacement_unit",
       .text = "No vertex ends farther than this from where it came; 0 sets no bound."},
      {.name = "max_displacement_unit",
       .kind = ParameterKind::Choice,
       .default_value = std::string("edges"),
       .choices = {"edges", "mesh"},
       .text = "Whether max_displacement counts mean edge lengths of the input or the mesh's own unit."},
      {.name = "preserve_volume",
       .kind = ParameterKind::Choice,
       .default_value = std::string("no"),
       .choices = {"no", "yes"},
       .text = "Whether the volume that each component lost is given back at the end, by an offset along the "
               "normals."},
      {.name = "lock_features",
       .default_value = 0.0,
       .minimum = 0,
       .maximum = 180,
       .unit = "degrees",
       .text = "Edges of the input that are sharper than this keep their line: vertices slide along it, and "
               "stay where such edges meet or end. 0 locks none."},
  };
}

IterationOptions iteration_options(const ParameterValues& values, const Surface& surface) {
  IterationOptions options;
  options.iterations = static_cast<std::uint32_t>(values.integer("iterations"));
  ConstraintOptions& constraints = options.constraints;
  constraints.boundary = values.choice("boundary") == "free" ? BoundaryRule::Free : BoundaryRule::Fixed;
  const double unit =
      values.choice("max_displacement_unit") == "edges" ? surface.mean_edge : 1 / surface.mesh.frame.scale();
  constraints.max_displacement = values.number("max_displacement") * unit;
  constraints.lock_features = values.number("lock_features");
  options.preserve_volume = values.choice("preserve_volume") == "yes";
  return options;
}

Result<SmoothOutcome> iterate(Surface& surface, const Constraints& constraints,
                              const IterationOptions& options, const RunControl& run, const Passes& passes) {
  std::vector<Vec3f>& home = surface.mesh.positions;
  Buffer<SimdVec3> from(home.size()), to(home.size());
  if (!for_each(home.size(), run, [&](std::size_t v) { from[v] = to[v] = SimdVec3(home[v]); })) {
    return run.stop_error();
  }
  SmoothOutcome outcome;
  for (; outcome.iterations < options.iterations; ++outcome.iterations) {
    if (passes.prepare && !passes.prepare(from)) return run.stop_error();
    std::atomic<bool> diverged = false;
    const bool done = parallel_for(home.size(), run, [&](std::size_t begin, std::size_t end) {
      passes.move(from, to, begin, end);
      if (!constraints.enforce(to, begin, end)) diverged.store(true, std::memory_order_relaxed);
    });
    if (!done) return run.stop_error();
    if (diverged.load()) {
      outcome.warnings.push_back({"diverged",
                                  "positions left the mesh in iteration " +
                                      std::to_string(outcome.iterations + 1) +
                                      "; the result is the one before it",
                                  1});
      break;
    }
    from.swap(to);
    run.report((outcome.iterations + 1.0) / options.iterations);
  }
  if (options.preserve_volume && !restore_volume(surface, constraints, from, run, outcome.warnings)) {
    return run.stop_error();
  }
  if (passes.finish && !passes.finish(from)) return run.stop_error();
  // Not to be stopped: half of the positions would be new ones.
  for_each(home.size(), {.threads = run.threads}, [&](std::size_t v) { home[v] = from[v].vec3(); });
  return outcome;
}

}  // namespace burnish
