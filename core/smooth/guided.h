// Guided mesh normal filtering: bilateral filtering of face normals whose weights come from a guidance that
// knows where the surface is even, and the vertices move to fit. Keeps sharp edges under much noise.
//
// W. Zhang, B. Deng, J. Zhang, S. Bouaziz, L. Liu, Guided mesh normal filtering, Computer Graphics Forum 34
// (Pacific Graphics 2015) 23-34.
#pragma once

#include "core/smooth/guided_filter.h"

namespace burnish {

struct GuidedParams {
  double sigma_r = 0.35;  ///< of the length of the difference of guidance normals, 0.01 to 10
  double sigma_s = 1;     ///< of the distance of centroids, in mean distances of adjacent ones, 0.1 to 100
  double radius = 2;      ///< of the neighbourhood, in the same unit and of the input, 0 to 4
  std::uint32_t normal_steps = 1;   ///< filterings of the normals per iteration, 1 to 100
  std::uint32_t vertex_steps = 10;  ///< moves of the vertices per iteration, 1 to 100
};

/// Each iteration measures the faces, filters their normals normal_steps times (see GuidedFilter), and
/// vertex_steps times moves v' = v + mean over triangles f at v of [(c(f) - v) . n'(f)] n'(f), c the
/// centroid (Sun et al. 2007). The paper filters once per iteration; iterations = 1 and more normal_steps
/// filter first and move the vertices after. A free boundary uses the triangles that there are. Moves
/// surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_guided(Surface& surface, const GuidedParams& params,
                                    const IterationOptions& options, const RunControl& run);

Method guided_method();

}  // namespace burnish
