// Bilateral normal filtering: face normals are averaged over neighbours that are near and turned alike, and
// the vertices move to fit. Keeps edges and corners. [8] does the like on graphics processors.
//
// Y. Zheng, H. Fu, O. K.-C. Au, C.-L. Tai, Bilateral normal filtering for mesh denoising, IEEE Transactions
// on Visualization and Computer Graphics 17 (2011) 1521-1530.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct BilateralNormalsParams {
  enum class Scheme : std::uint8_t {
    Local,  ///< every normal from its neighbours, normal_steps times
    Global  ///< all normals at once, a sparse system: dearer, and less of the noise stays in wide patches
  } scheme = Scheme::Local;
  double sigma_s = 0.45;  ///< of the length of the difference of unit normals, 0.01 to 10
  /// Of the distance of centroids, in mean distances of those of adjacent triangles, 0.1 to 100.
  double sigma_c = 1.5;
  FaceNeighbourhood neighbourhood = FaceNeighbourhood::Vertices;  ///< local; global: Edges
  std::uint32_t normal_steps = 1;                                 ///< local, per iteration, 1 to 100
  double lambda = 0.01;            ///< global: weight of the normals as they are, 0.001 to 1
  std::uint32_t vertex_steps = 2;  ///< moves of the vertices per iteration, 1 to 100
};

/// Local: n'(i) = unit(sum over neighbours j of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_c^2) - |n(i) - n(j)|^2 /
/// (2 sigma_s^2)) n(j)), c the centroid. Global: see BilateralSystem. Then vertex_steps times v' = v + mean
/// over triangles f at v of [(c(f) - v) . n'(f)] n'(f). A free boundary uses the triangles that there are.
/// Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_bilateral_normals(Surface& surface, const BilateralNormalsParams& params,
                                               const IterationOptions& options, const RunControl& run);

Method bilateral_normals_method();

}  // namespace burnish
