// Laplacian smoothing that pushes back what it took (Vollmer, Mencl, Mueller 1999, "HC"): each vertex goes to
// the mean of its neighbours, then towards where it was by the mean of what it and its neighbours went.
//
// J. Vollmer, R. Mencl, H. Mueller, Improved Laplacian smoothing of noisy surface meshes, Computer Graphics
// Forum 18(3)
// (1999) 131-138.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct HcLaplacianParams {
  double alpha = 0;  ///< pull back to the input o (1) or to the last iteration p (0), 0 to 1
  /// Share of a vertex's own way in what it is pushed back by, 0.5 to 1. Below 0.5 the highest frequencies
  /// would grow.
  double beta = 0.5;
};

/// q = p + U(p), b = q - (alpha o + (1 - alpha) p), p' = q - (beta b + (1 - beta) mean of the neighbours' b).
/// b is 0 where a vertex stays. With alpha = 0 that is p' = p - (1 - beta) U(U(p)), the bilaplacian step.
/// Free boundary vertices as in smooth_laplacian(). Moves surface.mesh.positions only. Errors: Cancelled,
/// DeadlineExceeded.
Result<SmoothOutcome> smooth_hc_laplacian(Surface& surface, const HcLaplacianParams& params,
                                          const IterationOptions& options, const RunControl& run);

Method hc_laplacian_method();

}  // namespace burnish
