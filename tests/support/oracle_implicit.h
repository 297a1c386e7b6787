// The implicit methods again, slow and plain: a dense matrix, elimination in double precision.
#pragma once

#include "core/smooth/implicit_mean_curvature_flow.h"
#include "core/smooth/weighted_least_squares.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// Smooths a shape without coinciding vertices; boundary vertices stay.
Shape oracle_implicit_mean_curvature_flow(const Shape& shape, const ImplicitMeanCurvatureFlowParams& params,
                                          int iterations);
Shape oracle_weighted_least_squares(const Shape& shape, const WeightedLeastSquaresParams& params,
                                    int iterations);

}  // namespace burnish::testing
