// The nearest triangle to a point.
#pragma once

#include <array>
#include <bit>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/run/run_control.h"

namespace burnish {

/// A hierarchy of boxes, eight to a node, that halves the triangles along their longest extent. Build is
/// O(n log n) on one thread, a query looks at about one node per level. Immutable after build, so many
/// threads may ask. The spans must outlive it; coordinates are at most kFarthest in magnitude.
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

 private:
  struct Box;
  struct Item;
  using Lanes = float __attribute__((vector_size(16)));  // what every x86-64 and ARM64 computes at once
  static constexpr std::size_t kLanes = 4, kWidth = 8;
  struct Node {  // the boxes of its children, by axis
    Lanes low[3][kWidth / kLanes], high[3][kWidth / kLanes];
  };

  /// A child and the squared distance of its box in one number that sorts by distance: the bits of a float
  /// that is not negative do.
  using Entry = std::uint64_t;
  static Entry entry(float squared, std::size_t child) {
    return Entry{std::bit_cast<std::uint32_t>(squared)} << 32 | child;
  }
  static std::size_t child_of(Entry e) { return e & 0xffff'ffffU; }

  Box grow(std::size_t node, std::span<Item> items, std::size_t unit, const RunControl& run);
  Box box_of(Index triangle) const;
  std::array<Entry, kWidth> entries(const Vec3f& point, std::size_t node) const;
  double to_box(const Vec3d& point, std::size_t child) const;
  double to_triangle(const Vec3d& point, Index triangle) const;

  std::span<const Vec3f> positions_;
  std::span<const Triangle> triangles_;
  std::vector<Node> nodes_;         // a heap: the children of i are 8i + 1 to 8i + 8
  std::size_t first_triangle_ = 1;  // children from this number on are triangles, in this order:
  std::vector<Index> order_;
};

/// Squared distance from a point to the nearest point of a triangle, which may be a line or a point.
double squared_distance(const Vec3d& point, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace burnish
