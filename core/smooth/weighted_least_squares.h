// Weighted least squares smoothing, after the idea of [9]: one sparse solve finds the surface that is near
// the old one and smooth except across features. The energy and its weights are ours; the paper of [9] was
// not at hand.
//
// [9] Zhang 2010, weighted least squares smoothing of meshes.
#pragma once

#include "core/smooth/iteration.h"
#include "core/smooth/sparse_system.h"

namespace burnish {

struct WeightedLeastSquaresParams {
  double lambda = 0.1;  ///< smoothness against nearness, in squared mean edge lengths of the input, 0 to 1000
  double sigma = 0.5;   ///< difference of unit normals across which little is smoothed, 0.01 to 100
  SolverOptions solver = {};
};

/// Each iteration finds the x that make
///     sum over vertices v of M(v) |x_v - p_v|^2 + lambda sum over edges vw of W(v, w) |x_v - x_w|^2
/// least, p the positions before it, M a third of the area at the vertex (at least 1e-4 h^2), W = exp(-|n(v)
/// - n(w)|^2 / sigma^2), n the unit area-weighted vertex normals; so the weights follow the surface as it
/// clears up. An edge along a crease joins equal normals and is smoothed, one that leaves the crease is not.
/// Every vertex becomes a mean of old positions: it shrinks, less than a flow, and not where W is small.
/// Triangles that wind against each other count as if they agreed. A free boundary uses the neighbours that
/// there are. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_weighted_least_squares(Surface& surface,
                                                    const WeightedLeastSquaresParams& params,
                                                    const IterationOptions& options, const RunControl& run);

Method weighted_least_squares_method();

}  // namespace burnish
