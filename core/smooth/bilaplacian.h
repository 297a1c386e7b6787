// Thin-plate smoothing: the umbrella operator applied twice [10]. It bends the surface as little as possible
// where the Laplacian stretches it as little as possible, so it takes less of the shape along with the noise.
//
// [10] L. Kobbelt, S. Campagna, J. Vorsatz, H.-P. Seidel, Interactive multi-resolution modeling on arbitrary
// meshes,
//      SIGGRAPH 1998, 105-114.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct BilaplacianParams {
  /// Step, 0 to 0.5. The transfer function of an iteration is 1 - lambda k^2 for frequencies k from 0 to 2:
  /// up to 0.5 none grows, up to 0.25, the default, none changes its sign.
  double lambda = 0.25;
};

/// v' = v - lambda U(U(v)), U the umbrella operator with equal weights. Kobbelt's factor 1/nu, nu = 1 + 1/n
/// sum 1/n_i, is left out: he visits vertices in turn, and with Jacobi steps it lets high frequencies grow.
///
/// U is that of the full ring at vertices that stay inside the surface, so that it bends smoothly around
/// them, and 0 on a boundary that stays, where there is no full ring: the border is a hinge. A free boundary
/// is smoothed along itself only, as by smooth_laplacian(). Moves surface.mesh.positions only. Errors:
/// Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_bilaplacian(Surface& surface, const BilaplacianParams& params,
                                         const IterationOptions& options, const RunControl& run);

Method bilaplacian_method();

}  // namespace burnish
