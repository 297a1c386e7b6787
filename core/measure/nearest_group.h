// Private to the nearest-triangle search: the walk for a group of points, with the widest vectors that the
// processor has. Whatever their width, every number comes out of the same operations in the same order: the
// same bits.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/mesh/topology.h"

namespace burnish::nearest_group {

/// From the lowest to the highest coordinates; as it begins it holds nothing.
struct Box {
  static constexpr float kFar = std::numeric_limits<float>::max();
  SimdVec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};

  [[gnu::always_inline]] void extend(const Box& by) {
    low = SimdVec3(by.low.lanes() < low.lanes() ? by.low.lanes() : low.lanes());
    high = SimdVec3(by.high.lanes() > high.lanes() ? by.high.lanes() : high.lanes());
  }
};

/// The boxes of a node's eight children, by axis; one without a child is empty.
struct alignas(32) Node {
  static constexpr std::size_t kWidth = 8;
  float low[3][kWidth], high[3][kWidth];
};

/// The hierarchy as core/measure/nearest.h has it. The children of node i are 8i + 1 to 8i + 8; from
/// `first_triangle` on they are the triangles order[0], order[1]...; `order` is as long as whole nodes are,
/// its last entry repeated.
struct Tree {
  std::span<const Node> nodes;
  std::size_t first_triangle;
  std::span<const Index> order;
  std::span<const Triangle> triangles;
  std::span<const SimdVec3> positions;
};

/// `squared[i]`: a squared distance from points[i] within which there is a triangle; becomes that of the
/// nearest. False, and nothing is done, when the points lie too wide for it to pay. At most kMost points.
using Find = bool (*)(const Tree& tree, std::span<const Vec3f> points, std::span<double> squared);
inline constexpr std::size_t kMost = 32;

/// The widest of this processor.
Find find();
/// All that this processor can run, for the test that they agree.
std::vector<Find> finds_here();

}  // namespace burnish::nearest_group
