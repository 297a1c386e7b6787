// Delaunay triangulation of points in the plane, for the procedural shapes.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace burnish::testing {

struct Point2 {
  double x = 0, y = 0;
};

/// The triangles of the convex hull, counter-clockwise, no corner of one inside the circle of another (Bowyer
/// and Watson's insertion, swept along x). For distinct points that are not all on one line; O(n^1.5).
std::vector<Triangle> delaunay(std::span<const Point2> points);

}  // namespace burnish::testing
