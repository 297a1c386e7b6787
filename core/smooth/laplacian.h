// Laplacian smoothing [1]: every vertex moves a part of the way to the mean of its neighbours. Simple, fast,
// shrinks.
//
// [1] D. A. Field, Laplacian smoothing and Delaunay triangulations, Communications in Applied Numerical
// Methods 4
//     (1988) 709-712. The paper under study uses the step 0.5.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct LaplacianParams {
  double lambda = 0.5;  ///< part of the way per iteration, 0 to 1
};

/// v' = v + lambda U(v), U the umbrella operator with equal weights (Eq. 3). A free boundary vertex is
/// averaged with its two neighbours along the boundary only, so that borders smooth as curves and are not
/// pulled inwards. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_laplacian(Surface& surface, const LaplacianParams& params,
                                       const IterationOptions& options, const RunControl& run);

Method laplacian_method();

}  // namespace burnish
