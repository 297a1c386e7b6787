// The nearest triangle to a point.
#pragma once

#include <array>
#include <bit>
#include <span>
#include <vector>

#include "core/measure/nearest_group.h"
#include "core/mesh/mesh.h"
#include "core/run/buffer.h"
#include "core/run/run_control.h"

namespace burnish {

/// A hierarchy of boxes, eight to a node, over the triangles in their own order or, when that jumps about, in
/// the order of a space-filling curve. Build is
/// O(n), a query looks at one or two nodes per level. Immutable after build, so many threads may ask.
/// `triangles` must outlive it; coordinates are at most kFarthest in magnitude.
/// docs/decisions/0006-nearest-triangle.md compares it with Embree's point query.
class NearestTriangle {
 public:
  static constexpr float kFarthest = 1e18F;  ///< squares of distances stay within float

  struct Hit {
    double squared_distance;
    Index triangle;
  };

  /// Errors: Cancelled, DeadlineExceeded.
  static Result<NearestTriangle> build(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                                       const RunControl& run);

  /// The nearest point over all triangles; `start` is a triangle that is likely near: the nearer, the faster.
  /// There must be a triangle.
  Hit find(const Vec3f& point, Index start) const;

  /// Points that find_all() takes at once.
  static constexpr std::size_t kGroup = 32;
  /// The same for kGroup points or fewer that lie together: one walk through the hierarchy finds the
  /// triangles near any of them. `squared` holds, for each point, a squared distance within which a triangle
  /// is known to be, and becomes the squared distance of the nearest. `start` is for when the points lie too
  /// wide. When stopped, the distances mean nothing.
  void find_all(std::span<const Vec3f> points, std::span<double> squared, Index start,
                const RunControl& run) const;

 private:
  using Box = nearest_group::Box;
  using Node = nearest_group::Node;
  static constexpr std::size_t kWidth = Node::kWidth;

  /// A child and the squared distance of its box in one number that sorts by distance: the bits of a float
  /// that is not negative do.
  using Entry = std::uint64_t;
  static Entry entry(float squared, std::size_t child) {
    return Entry{std::bit_cast<std::uint32_t>(squared)} << 32 | child;
  }
  static std::size_t child_of(Entry e) { return e & 0xffff'ffffU; }

  bool fill(const RunControl& run);
  bool in_good_order() const;
  Box box_of(Index triangle) const;
  Box box_of_children(std::size_t node) const;
  void set_box(std::size_t node, std::size_t child, const Box& box);
  Box set_boxes(std::size_t node, const Index* triangles);
  std::array<Entry, kWidth> entries(const Vec3f& point, std::size_t node) const;
  double to_box(const Vec3d& point, std::size_t child) const;
  double to_triangle(const Vec3d& point, Index triangle) const;

  Buffer<SimdVec3> positions_;
  std::span<const Triangle> triangles_;
  Buffer<Node> nodes_;              // a heap: the children of i are 8i + 1 to 8i + 8
  std::size_t first_triangle_ = 1;  // children from this number on are triangles, in this order:
  Buffer<Index> order_;
};

/// Squared distance from a point to the nearest point of a triangle, which may be a line or a point.
double squared_distance(const Vec3d& point, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace burnish
