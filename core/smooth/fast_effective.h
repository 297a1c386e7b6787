// Fast and effective feature-preserving denoising: face normals are averaged over neighbours whose normals
// differ little, and the vertices move to fit.
//
// X. Sun, P. L. Rosin, R. R. Martin, F. C. Langbein, Fast and effective feature-preserving mesh denoising,
// IEEE Transactions on Visualization and Computer Graphics 13 (2007) 925-938.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct FastEffectiveParams {
  /// When normals are filtered: before every vertex step, which denoises best, or once, before the first, as
  /// printed (there with 20 normal_steps).
  enum class Filtering : std::uint8_t { EveryIteration, Once } filtering = Filtering::EveryIteration;
  std::uint32_t normal_steps = 2;  ///< how often normals are filtered in a row, 1 to 100
  /// T: cosine of the angle from which on a neighbour does not count, 0 to 0.99. Less for more noise.
  double threshold = 0.5;
  FaceNeighbourhood neighbourhood = FaceNeighbourhood::Vertices;
};

/// n'(i) = unit(sum over neighbours j of max(n(i) . n(j) - T, 0)^2 n(j)), n(i) where the sum vanishes; then
/// v' = v + mean over triangles f at v of [(c(f) - v) . n'(f)] n'(f), c the centroid. A free boundary uses
/// the triangles that there are. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_fast_effective(Surface& surface, const FastEffectiveParams& params,
                                            const IterationOptions& options, const RunControl& run);

Method fast_effective_method();

}  // namespace burnish
