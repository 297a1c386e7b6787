// Mean curvature flow [4], explicit: every vertex moves along its mean curvature normal, by time steps.
//
// [4] M. Desbrun, M. Meyer, P. Schroeder, A. H. Barr, Implicit fairing of irregular meshes using diffusion
// and
//     curvature flow, SIGGRAPH 1999, 317-324.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct MeanCurvatureFlowParams {
  double time_step = 0.025;  ///< per iteration, in squared mean edge lengths of the input, 0 to 10
  /// Cotangents are clamped to [0, this], 0.01 to 1000. Slivers have huge ones and obtuse triangles negative
  /// ones, and on noisy scans both make the explicit flow diverge; without negative weights every step is an
  /// average.
  double largest_cotangent = 10;
};

/// v' = v + dt/M sum_w (cot a + cot b)/2 (w - v), M a third of the area of the triangles at v. The share of
/// the way to the weighted mean, dt/M sum (cot a + cot b)/2, is bounded by 1, beyond which the explicit step
/// overshoots. On a sphere of good triangles r^2 = r0^2 - 4t. A free boundary uses the triangles that there
/// are. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_mean_curvature_flow(Surface& surface, const MeanCurvatureFlowParams& params,
                                                 const IterationOptions& options, const RunControl& run);

Method mean_curvature_flow_method();

}  // namespace burnish
