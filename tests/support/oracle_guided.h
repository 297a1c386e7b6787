// Guided and robust normal filtering again, slow and plain: double precision and sets.
#pragma once

#include "core/smooth/guided.h"
#include "core/smooth/robust_normals.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// Smooths a shape without coinciding vertices, without non-manifold edges, all wound alike; boundary
/// vertices stay.
Shape oracle_guided(const Shape& shape, const GuidedParams& params, int iterations);
Shape oracle_robust_normals(const Shape& shape, const RobustNormalsParams& params, int iterations);

}  // namespace burnish::testing
