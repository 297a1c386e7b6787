// Two-stage filtering of face normals with a robust weight, Tukey's biweight, that gives neighbours turned
// farther than a threshold no weight at all, and a move of the vertices that keeps the volume.
//
// After S. K. Yadav, U. Reitebuch, K. Polthier, Robust and high fidelity mesh denoising, IEEE Transactions on
// Visualization and Computer Graphics 25 (2019) 2304-2310. The paper was not at hand: the formulas are ours.
#pragma once

#include "core/smooth/robust_filter.h"

namespace burnish {

struct RobustNormalsParams {
  /// Difference of unit normals from which on a neighbour does not count, 0.01 to 10: of the normals as they
  /// are in the first stage, and of those that it gave in the second.
  double first_threshold = 2, second_threshold = 0.4;
  /// Of the distance of centroids, in mean distances of those of adjacent triangles, 0.1 to 100.
  double sigma_c = 1.5;
  std::uint32_t normal_steps = 2;  ///< filterings in a row in each stage, 1 to 100
  std::uint32_t vertex_steps = 2;  ///< moves of the vertices per iteration, 1 to 100
};

/// Each iteration measures the faces, filters their normals (see RobustFilter, over the triangles that share
/// a vertex, normal_steps in each stage), and vertex_steps times moves v' = v + o(v) - mu u(v): o(v) = sum
/// over triangles f at v of A(f) n'(f) [n'(f) . (a + b - 2 v) / 3] / sum A(f), a and b the far ends of f's
/// edges at v, which makes them orthogonal to n'(f); u(v) the unit normal along the gradient G(v) of the
/// volume, mu = sum G . o / sum |G| over all that move, so that to first order the volume stays. A free
/// boundary uses the triangles that there are. Moves surface.mesh.positions only. Errors: Cancelled,
/// DeadlineExceeded.
Result<SmoothOutcome> smooth_robust_normals(Surface& surface, const RobustNormalsParams& params,
                                            const IterationOptions& options, const RunControl& run);

Method robust_normals_method();

}  // namespace burnish
