// The nearest triangle to a point.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/run/run_control.h"

namespace burnish {

/// A hierarchy of boxes over triangles sorted along a Morton curve. Build is O(n log n); a query that starts
/// from a triangle close by looks at a few dozen boxes. Immutable after build, so many threads may ask. The
/// spans must outlive it. docs/decisions/0006-nearest-triangle.md compares it with Embree's point query.
class NearestTriangle {
 public:
  struct Hit {
    double squared_distance;
    Index triangle;
  };

  /// Errors: Cancelled, DeadlineExceeded.
  static Result<NearestTriangle> build(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                                       const RunControl& run);

  /// The nearest point over all triangles; `start` is a triangle that is likely near. There must be a
  /// triangle.
  Hit find(const Vec3d& point, Index start) const;

 private:
  struct Box {
    Vec3f low, high;
  };

  double to_box(const Vec3d& point, std::size_t node) const;
  double to_triangle(const Vec3d& point, Index triangle) const;

  std::span<const Vec3f> positions_;
  std::span<const Triangle> triangles_;
  std::vector<Index> order_;  // triangles along the curve; kLeaf of them to a leaf
  std::vector<Box> boxes_;    // a binary heap: the children of i are 2i and 2i + 1
  std::size_t first_leaf_ = 1;
};

/// Squared distance from a point to the nearest point of a triangle, which may be a line or a point.
double squared_distance(const Vec3d& point, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace burnish
