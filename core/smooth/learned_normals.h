// Face normals predicted by a cascade of small networks from a dozen filtered ones, and vertices moved to
// fit: the cascaded normal regression of [1] with networks over differences of fields instead of regressions
// over aligned normals. Each stage sees the mesh that the one before it made.
//
// [1] P.-S. Wang, Y. Liu, X. Tong, Mesh denoising via cascaded normal regression, ACM Transactions on
// Graphics
//     35 (SIGGRAPH Asia 2016) 232.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

inline constexpr std::uint32_t kLearnedStages = 3;  ///< default of `iterations`

struct LearnedNormalsParams {
  std::uint32_t vertex_steps = 20;  ///< steps of the vertices per stage, 1 to 1000
  /// Rings over which what the steps took away is averaged and given back, see CascadeOptions; 0 to 100.
  std::uint32_t give_back = 3, give_back_flat = 30;
  /// After the last stage, filterings of the normals where the surface is made of facets, see
  /// smooth_facets(); 0 to 100.
  std::uint32_t facet_steps = 10;
  /// After that, moves of the vertices onto the surface's planes, see settle_on_planes(); 0 to 100.
  std::uint32_t plane_steps = 20;
  /// Which vertices move: all, or only those that stand out, while the others stay to the bit. For impulsive
  /// noise, which leaves most vertices where they belong; see find_outliers().
  enum class Moves : std::uint8_t { All, Outliers } moves = Moves::All;
  /// Share of the way to go, 0 to 2. Above 1, on towards a surface that is smoother than learned.
  double strength = 1;
};

/// `iterations` of the options are stages; those beyond the networks that there are use the last one.
/// A triangle that agreed with its predicted normal before still does afterwards.
/// Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_learned_normals(Surface& surface, const LearnedNormalsParams& params,
                                             const IterationOptions& options, const RunControl& run);

Method learned_normals_method();

}  // namespace burnish
