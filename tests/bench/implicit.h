// One implicit step by CGAL, for implicit_bench; in a file of its own, because its headers take long to
// compile.
#pragma once

#include <optional>
#include <vector>

#include "tests/support/shapes.h"

namespace burnish::bench {

struct ImplicitStep {
  double seconds = 0;  ///< CPU time of assembly and solution
  std::vector<Vec3d> positions;
};

/// CGAL::Polygon_mesh_processing::smooth_shape; time in the shape's squared unit. Its solver stops at the
/// relative residual `tolerance`; 0: as CGAL has it. Two vertices stay, for then it does not rescale. Unset
/// when its solver gives up.
std::optional<ImplicitStep> cgal_step(const testing::Shape& shape, double time, double tolerance);

}  // namespace burnish::bench
