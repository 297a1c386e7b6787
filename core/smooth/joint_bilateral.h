// Joint bilateral filtering of face normals and constrained Laplacian smoothing, after [3]: weights come from
// a smoothed copy of the normals, which noise disturbs less, and vertices stay near the input.
//
// [3] M. Wei et al., feature-preserving optimization for noisy meshes by joint bilateral filter and
// constrained
//     Laplacian smoothing, 2013. The filter's guide, the step and its constraints are ours.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct JointBilateralParams {
  double sigma_s = 0.1;  ///< of the length of the difference of the guide's normals, 0.01 to 10
  /// Of the distance of centroids, in mean distances of those of adjacent triangles, 0.1 to 100.
  double sigma_c = 1.5;
  std::uint32_t guide_steps = 1;   ///< means over the neighbours that make the guide, 1 to 100
  double laplacian = 0.05;         ///< part of the way to the tangential mean of the neighbours, 0 to 1
  std::uint32_t vertex_steps = 2;  ///< moves of the vertices per iteration, 1 to 100
  double distance = 2;             ///< from the input, in its mean edge lengths, 0.001 to 1000
};

/// g(i): the normals after guide_steps area-weighted means over the triangles that share a vertex;
/// n'(i) = unit(sum over them of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_c^2) - |g(i) - g(j)|^2 / (2 sigma_s^2))
/// n(j)), c the centroid; then vertex_steps times
/// v' = v + mean over triangles f at v of [(c(f) - v) . n'(f)] n'(f) + laplacian (U - (U . n) n), U the
/// umbrella vector, n the area-weighted mean of n'(f), pulled back to within `distance` of the input: a
/// descent on the misfit of faces and normals, with the Laplacian constrained to the surface. A free boundary
/// does not slide. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_joint_bilateral(Surface& surface, const JointBilateralParams& params,
                                             const IterationOptions& options, const RunControl& run);

Method joint_bilateral_method();

}  // namespace burnish
