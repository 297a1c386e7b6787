// Mean filtering of face normals [7]: every normal becomes the area-weighted mean of its neighbours', and
// the vertices move to fit. Removes noise well; rounds edges.
//
// [7] H. Yagou, Y. Ohtake, A. Belyaev, Mesh smoothing via mean and median filtering applied to face normals,
//     Geometric Modeling and Processing 2002, 124-131.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct MeanNormalsParams {
  FaceNeighbourhood neighbourhood = FaceNeighbourhood::Edges;
};

/// One iteration, as [7] repeats it: m(T) = unit(sum of A(S) n(S)) over the neighbours S of T, then
/// v' = v + 1/sum A(T) sum A(T) [(c(T) - v) . m(T)] m(T) over the triangles T at v, c(T) the centroid. A free
/// boundary uses the triangles that there are. Moves surface.mesh.positions only. Errors: Cancelled,
/// DeadlineExceeded.
Result<SmoothOutcome> smooth_mean_normals(Surface& surface, const MeanNormalsParams& params,
                                          const IterationOptions& options, const RunControl& run);

Method mean_normals_method();

}  // namespace burnish
