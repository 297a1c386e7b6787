// The filters of vertices again, slow and plain: double precision, straight from the papers' formulas.
#pragma once

#include "core/smooth/bilateral.h"
#include "core/smooth/hc_laplacian.h"
#include "core/smooth/windowed_sinc.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// Smooths a shape without coinciding vertices; boundary vertices stay.
Shape oracle_bilaplacian(const Shape& shape, double lambda, int iterations);
Shape oracle_hc_laplacian(const Shape& shape, const HcLaplacianParams& params, int iterations);
Shape oracle_windowed_sinc(const Shape& shape, const WindowedSincParams& params, int degree);
Shape oracle_bilateral(const Shape& shape, const BilateralParams& params, int iterations);

/// f(k) of windowed_sinc.
double oracle_sinc_transfer(const WindowedSincParams& params, int degree, double k);

}  // namespace burnish::testing
