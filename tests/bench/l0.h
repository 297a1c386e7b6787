// Mesh denoising by L0 minimisation: looks for the least squared distance to the input plus lambda times the
// number of bent edges, those with D(e) p != 0. Only the denoising benchmark has it:
// docs/decisions/0022-l0-minimisation.md.
//
// L. He, S. Schaefer, Mesh denoising via L0 minimization, ACM Transactions on Graphics 32 (SIGGRAPH 2013)
// 64:1-64:8.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish::bench {

struct L0Params {
  double lambda = 0.2;          ///< over h^2 times the mean angle at an edge of the input, in radians
  double alpha = 0.1;           ///< over that angle; 0: no regulariser
  double mu = 1.4142135623731;  ///< beta grows by this per iteration, from 1e-3 to 1e3; above 1
};

/// The corners around an edge p[0] p[2]: its triangles are p[0] p[1] p[2] and p[0] p[2] p[3].
using EdgeCorners = std::array<Vec3d, 4>;

/// The paper's area-based edge operator D(e): weights of the corners whose sum is 0, and 0 in the plane. All
/// are 0 where the square of the edge, or twice the area, is not above `least`.
std::array<double, 4> edge_operator(const EdgeCorners& p, double least);

/// Until beta has grown, or options.iterations times: delta(e) = D(e) p where that is longer than
/// sqrt(lambda / beta), else 0; then p minimises |p - input|^2 + alpha sum |R(e) p|^2 + beta sum |D(e) p -
/// delta(e)|^2, R(e) p = p0 - p1 + p2 - p3; alpha is halved. Edges with one triangle take no part. Moves
/// surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_l0(Surface& surface, const L0Params& params, const IterationOptions& options,
                                const RunControl& run);

/// "l0"
const Method& l0_method();

}  // namespace burnish::bench
