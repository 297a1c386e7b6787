// Mean curvature flow [4], implicit: each step solves a linear system, and may be as long as one likes.
//
// [4] M. Desbrun, M. Meyer, P. Schroeder, A. H. Barr, Implicit fairing of irregular meshes using diffusion
// and
//     curvature flow, SIGGRAPH 1999, 317-324.
#pragma once

#include "core/smooth/iteration.h"
#include "core/smooth/sparse_system.h"

namespace burnish {

struct ImplicitMeanCurvatureFlowParams {
  double time_step = 0.1;         ///< per iteration, in squared mean edge lengths of the input, 0 to 1000
  double largest_cotangent = 10;  ///< as in MeanCurvatureFlowParams, 0.01 to 1000
  SolverOptions solver = {};
};

/// (M - dt L) X' = M X, M a third of the area of the triangles at the vertex, L with the weights (cot a + cot
/// b)/2, both from the positions X. No step overshoots: with the clamped weights every vertex becomes a mean
/// of old and fixed positions. On a sphere of good triangles r^2 = r0^2 - 4t for steps that are short beside
/// r^2; a step takes r to r/(1 + 2 dt/r^2). The mass is at least 1e-4 h^2, so that slivers and what has
/// shrunk to a point keep the system solvable. A free boundary uses the triangles that there are. Moves
/// surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_implicit_mean_curvature_flow(Surface& surface,
                                                          const ImplicitMeanCurvatureFlowParams& params,
                                                          const IterationOptions& options,
                                                          const RunControl& run);

Method implicit_mean_curvature_flow_method();

}  // namespace burnish
