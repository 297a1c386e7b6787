// Every method again, slow and plain: double precision, no flat lists, straight from the papers' formulas.
#pragma once

#include "core/smooth/adaptive.h"
#include "core/smooth/mean_curvature_flow.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// Smooths a shape without coinciding vertices; boundary vertices stay.
Shape oracle_laplacian(const Shape& shape, double lambda, int iterations);
Shape oracle_taubin(const Shape& shape, double lambda, double mu, int iterations);
Shape oracle_mean_curvature_flow(const Shape& shape, const MeanCurvatureFlowParams& params, int iterations);
Shape oracle_adaptive(const Shape& shape, const AdaptiveParams& params, int iterations);

double oracle_mean_edge(const Shape& shape);
/// Eq. 9 by trying every triangle for every vertex.
double oracle_ev(const Shape& result, const Shape& reference);

}  // namespace burnish::testing
