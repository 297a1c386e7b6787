#include "core/smooth/iteration.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Positions this many diagonals away have diverged; stopping here keeps every square and cube finite.
constexpr float kFarthest = 1e6F;

/// What writing a coordinate as text may add to a displacement, in local units: max_displacement holds in the
/// file.
constexpr double kTextSlack = 0x1p-22;

bool bounded(SimdVec3 p) {  // false for NaN too
  return std::abs(p.x()) <= kFarthest && std::abs(p.y()) <= kFarthest && std::abs(p.z()) <= kFarthest;
}

/// The point on the way from `home` to `p` that is at most `limit` from home, after rounding to float.
Vec3f pull_back(const Vec3f& home, const Vec3f& p, double limit) {
  const Vec3d start = to_double(home), way = to_double(p) - start;
  const double distance = length(way);
  if (!(distance > limit)) return p;
  for (int share = 64; share > 32; --share) {  // in 64ths; rounding rarely needs the second
    const Vec3f near = to_float(start + way * (share * limit / (64 * distance)));
    if (length(to_double(near) - start) <= limit) return near;
  }
  return home;
}

}  // namespace

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
  };
}

IterationOptions iteration_options(const ParameterValues& values, const Surface& surface) {
  IterationOptions options;
  options.iterations = static_cast<std::uint32_t>(values.integer("iterations"));
  options.boundary = values.choice("boundary") == "free" ? BoundaryRule::Free : BoundaryRule::Fixed;
  const double unit =
      values.choice("max_displacement_unit") == "edges" ? surface.mean_edge : 1 / surface.mesh.frame.scale();
  options.max_displacement = values.number("max_displacement") * unit;
  return options;
}

std::vector<std::uint8_t> movable_vertices(const Topology& topology, BoundaryRule boundary) {
  int stays = kIsolatedVertex | kNonManifoldVertex;
  if (boundary == BoundaryRule::Fixed) stays |= kBoundaryVertex;
  std::vector<std::uint8_t> movable(topology.vertex_flags.size());
  for (std::size_t v = 0; v < movable.size(); ++v) movable[v] = (topology.vertex_flags[v] & stays) == 0;
  return movable;
}

Result<SmoothOutcome> iterate(Surface& surface, std::span<const std::uint8_t> movable,
                              const IterationOptions& options, const RunControl& run,
                              const Advance& advance) {
  std::vector<Vec3f>& home = surface.mesh.positions;
  std::vector<SimdVec3> from(home.begin(), home.end()), to = from;
  const bool limited = options.max_displacement > 0;
  const double limit = std::max(0.0, options.max_displacement - kTextSlack);
  SmoothOutcome outcome;
  for (; outcome.iterations < options.iterations; ++outcome.iterations) {
    if (!advance(from, to)) return run.stop_error();
    std::atomic<bool> diverged = false;
    const bool done = parallel_for(home.size(), run, [&](std::size_t begin, std::size_t end) {
      bool fine = true;
      for (std::size_t v = begin; v < end; ++v) {
        if (!movable[v]) continue;
        fine &= bounded(to[v]);
        if (limited) to[v] = SimdVec3(pull_back(home[v], to[v].vec3(), limit));
      }
      if (!fine) diverged.store(true, std::memory_order_relaxed);
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
  std::ranges::transform(from, home.begin(), &SimdVec3::vec3);
  return outcome;
}

}  // namespace burnish
