// What all iterative methods share: options, which vertices may move, and the loop around one iteration.
#pragma once

#include <functional>
#include <span>

#include "core/mesh/simd_vec3.h"
#include "core/smooth/registry.h"

namespace burnish {

enum class BoundaryRule : std::uint8_t {
  Fixed,  ///< vertices on open edges stay where they are
  Free,   ///< they move as the method says
};

struct IterationOptions {
  std::uint32_t iterations = 20;  ///< 0 to kMostIterations
  BoundaryRule boundary = BoundaryRule::Fixed;
  /// No vertex ends farther than this from where it came, in local units; 0 = no bound.
  double max_displacement = 0;
};

inline constexpr std::uint32_t kMostIterations = 100'000;

/// The specs of the parameters that every iterative method has: iterations, boundary, max_displacement and
/// its unit.
std::vector<ParameterSpec> iteration_parameters();
IterationOptions iteration_options(const ParameterValues& values, const Surface& surface);

/// Per vertex, 1 when a method may move it: not isolated, not non-manifold, not on a fixed boundary.
std::vector<std::uint8_t> movable_vertices(const Topology& topology, BoundaryRule boundary);

/// Computes one iteration: reads every position of `from`, writes those of movable vertices to `to`.
/// False when it stopped half-way. Entries of `to` for other vertices are already right.
using Advance = std::function<bool(std::span<const SimdVec3> from, std::span<SimdVec3> to)>;

/// The loop: advance, bound displacements, check that all is finite, report progress. Writes back last.
/// Diverging positions end the loop at the last good iteration, with the warning "diverged".
Result<SmoothOutcome> iterate(Surface& surface, std::span<const std::uint8_t> movable,
                              const IterationOptions& options, const RunControl& run, const Advance& advance);

}  // namespace burnish
