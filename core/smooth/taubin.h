// Smoothing that nearly keeps volume [2]: a shrinking step lambda, then a growing step mu. Together they are
// a low-pass filter over the eigenvectors of the umbrella operator.
//
// [2] G. Taubin, A signal processing approach to fair surface design, SIGGRAPH 1995, 351-358.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct TaubinParams {
  double lambda = 0.5;  ///< shrinking step, 0 to 1
  double mu = -0.53;    ///< growing step, -1.1 to 0; pass band kPB = 1/lambda + 1/mu
};

/// One iteration is both steps: v' = v + lambda U(v), then v'' = v' + mu U(v'). Free boundary vertices as in
/// smooth_laplacian(). Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_taubin(Surface& surface, const TaubinParams& params,
                                    const IterationOptions& options, const RunControl& run);

Method taubin_method();

}  // namespace burnish
