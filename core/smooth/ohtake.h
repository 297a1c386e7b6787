// Mesh regularisation and adaptive smoothing [5]: the normals of the faces diffuse, less where the surface
// bends much, the vertices move to fit them, and slide within the surface towards better triangles.
//
// [5] Y. Ohtake, A. G. Belyaev, I. A. Bogaevski, Mesh regularization and adaptive smoothing, Computer-Aided
//     Design 33 (2001) 789-800. The offsets are Eq. 2 of the paper, which takes them from there; the weights
//     of the diffusion and of the sliding are ours.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct OhtakeParams {
  /// Bending, in radians per mean edge length of the input, at which a neighbour counts exp(-1/2): less keeps
  /// smaller features, and more of the noise. 0.1 to 100.
  double curvature = 0.6;
  double regularisation = 0.1;  ///< part of the way to the tangential mean of the neighbours, 0 to 1
  FaceNeighbourhood neighbourhood = FaceNeighbourhood::Vertices;
};

/// m(T) = unit(sum over neighbours S of A(S) exp(-k^2 / (2 curvature^2)) n(S)),
/// k = h |n(S) - n(T)| / |c(S) - c(T)|, c the centroid; then, over the triangles T at v,
/// v' = v + 1/sum A(T) sum A(T) [(c(T) - v) . m(T)] m(T) + regularisation (U - (U . n) n), U the umbrella
/// vector, n the area-weighted mean of m(T). On a free boundary nothing slides. Moves surface.mesh.positions
/// only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_ohtake(Surface& surface, const OhtakeParams& params,
                                    const IterationOptions& options, const RunControl& run);

Method ohtake_method();

}  // namespace burnish
