// What all iterative methods share: options and the loop around one iteration.
#pragma once

#include <functional>
#include <span>

#include "core/mesh/simd_vec3.h"
#include "core/smooth/constraints.h"
#include "core/smooth/registry.h"

namespace burnish {

struct IterationOptions {
  std::uint32_t iterations = 20;  ///< 0 to kMostIterations
  ConstraintOptions constraints = {};
  bool preserve_volume = false;  ///< at the end, see restore_volume()
};

inline constexpr std::uint32_t kMostIterations = 100'000;

/// The specs of the parameters that every method has.
std::vector<ParameterSpec> iteration_parameters();
IterationOptions iteration_options(const ParameterValues& values, const Surface& surface);

/// One iteration, in two parts, and what comes after the last.
struct Passes {
  /// What the moves need of all positions first: face normals, another step, a solution. False when it
  /// stopped half-way. May be empty.
  std::function<bool(std::span<const SimdVec3> from)> prepare = {};
  /// Writes to[v] for every movable v in [begin, end); other entries of `to` are already right. Called on
  /// several threads at once.
  std::function<void(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
                     std::size_t end)>
      move;
  /// Looks at the positions that are to be written, and takes some back on their straight way from where they
  /// came, which breaks no constraint. False when it stopped half-way. May be empty.
  std::function<bool(std::span<SimdVec3> positions)> finish = {};
};

/// The loop: prepare, move, enforce the constraints, report progress; then restore the volume if asked,
/// finish, and write back. Positions that diverge end the loop at the last good iteration, with the warning
/// "diverged". Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> iterate(Surface& surface, const Constraints& constraints,
                              const IterationOptions& options, const RunControl& run, const Passes& passes);

}  // namespace burnish
