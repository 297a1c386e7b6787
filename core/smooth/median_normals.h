// Median filtering of face normals [7]: every normal becomes that of the neighbour whose angle to it is the
// weighted median, and the vertices move to fit. Keeps edges that the mean rounds.
//
// [7] H. Yagou, Y. Ohtake, A. Belyaev, Mesh smoothing via mean and median filtering applied to face normals,
//     Geometric Modeling and Processing 2002, 124-131.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct MedianNormalsParams {
  /// Of a neighbour across an edge; one across a vertex alone weighs 1. 0 to 100.
  double edge_weight = 2;
};

/// One iteration, as [7] repeats it: m(T) = n(S), S the neighbour of T at which the weighted median of the
/// angles between n(T) and its neighbours' normals falls; then the vertices move as in smooth_mean_normals().
/// Neighbours share a vertex. Where half the weights lie on either side the smaller angle is taken;
/// neighbours at the median's angle (within 1e-4 rad or 0.05 %) are averaged by weight, so that on symmetric
/// meshes rounding does not choose. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_median_normals(Surface& surface, const MedianNormalsParams& params,
                                            const IterationOptions& options, const RunControl& run);

Method median_normals_method();

}  // namespace burnish
