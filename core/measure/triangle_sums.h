// Private to the measures: sums over a block of triangles, four at a time in double, with the widest vectors
// that the processor has. Whatever their width, every number comes out of the same operations in the same
// order: the same bits.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace burnish::triangle_sums {

/// The cotangent of a triangle's smallest angle as a fraction: the largest dot product of two sides over
/// their cross product, which all three angles share.
struct Cotangent {
  double dot = 0, cross = 1;
  bool operator<(const Cotangent& b) const { return dot * b.cross < b.dot * cross; }
};

struct Shape {
  double area = 0, volume = 0;  ///< signed volume about 0
  Cotangent sharpest;           ///< a triangle without area has the angle 0
};

struct Errors {
  double area = 0;
  double weighted = 0;                   ///< sum of area times the squared distances at the three corners
  double angles = 0, largest_angle = 0;  ///< radians, between the normals of the triangles that have two
  std::uint32_t compared = 0,
                flipped = 0;  ///< those triangles, and those that turned by more than 90 degrees
};

struct Functions {
  Shape (*shape)(std::span<const Triangle> triangles, std::span<const Vec3f> positions);
  /// `squared` by vertex; `others` the positions to compare the normals with, empty: not asked for.
  Errors (*errors)(std::span<const Triangle> triangles, std::span<const Vec3f> positions,
                   std::span<const double> squared, std::span<const Vec3f> others);
};

/// The widest of this processor.
const Functions& functions();
/// All that this processor can run, for the test that they agree.
std::vector<Functions> functions_here();

}  // namespace burnish::triangle_sums
