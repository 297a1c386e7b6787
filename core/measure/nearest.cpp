#include "core/measure/nearest.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr std::size_t kLeaf = 4;

constexpr int kBitsPerAxis = 16;

/// Spreads the low 16 bits so that two others fit between each.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 16) & 0xff'0000ffU;
  x = (x | x << 8) & 0x100f'00f0'0f00'f00fU;
  x = (x | x << 4) & 0x10c3'0c30'c30c'30c3U;
  return (x | x << 2) & 0x1249'2492'4924'9249U;
}

struct Key {
  std::uint64_t code;
  Index triangle;
};

/// By digits from the lowest: stable, linear, and it can be stopped between passes, which std::sort cannot.
bool sort_by_code(std::vector<Key>& keys, const RunControl& run) {
  constexpr int kDigitBits = 12;
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  std::vector<Key> sorted(keys.size());
  for (int shift = 0; shift < 3 * kBitsPerAxis; shift += kDigitBits) {
    if (run.stopped()) return false;
    std::vector<std::size_t> next(kDigits + 1, 0);
    const auto digit = [&](const Key& key) { return key.code >> shift & (kDigits - 1); };
    for (const Key& key : keys) ++next[digit(key) + 1];
    for (std::size_t d = 0; d < kDigits; ++d) next[d + 1] += next[d];
    for (const Key& key : keys) sorted[next[digit(key)]++] = key;
    keys.swap(sorted);
  }
  return !run.stopped();
}

double squared_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d along = b - a, to = p - a;
  const double size = dot(along, along);
  const double t = size > 0 ? std::clamp(dot(to, along) / size, 0.0, 1.0) : 0.0;
  const Vec3d rest = to - along * t;
  return dot(rest, rest);
}

}  // namespace

double squared_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d normal = cross(b - a, c - a);
  const double size = dot(normal, normal);
  const bool above = size > 0 && dot(cross(b - a, p - a), normal) >= 0 &&
                     dot(cross(c - b, p - b), normal) >= 0 && dot(cross(a - c, p - c), normal) >= 0;
  if (above) {
    const double height = dot(p - a, normal);
    return height * height / size;
  }
  return std::min({squared_to_segment(p, a, b), squared_to_segment(p, b, c), squared_to_segment(p, c, a)});
}

Result<NearestTriangle> NearestTriangle::build(std::span<const Vec3f> positions,
                                               std::span<const Triangle> triangles, const RunControl& run) {
  constexpr float kFar = std::numeric_limits<float>::max();
  constexpr Box kNothing{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  const auto merge = [](Box& box, const Box& other) {  // an empty box changes nothing
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], other.low[axis]);
      box.high[axis] = std::max(box.high[axis], other.high[axis]);
    }
  };
  NearestTriangle tree;
  tree.positions_ = positions;
  tree.triangles_ = triangles;

  Box all = kNothing;
  for (const Vec3f& p : positions) merge(all, {p, p});
  std::vector<Key> keys(triangles.size());
  const Vec3d low = to_double(all.low), extent = to_double(all.high) - low;
  const double largest = std::max({extent.x, extent.y, extent.z, 1e-300});
  const bool keyed = parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Triangle& corners = triangles[t];
      const Vec3d centroid = (to_double(positions[corners[0]]) + to_double(positions[corners[1]]) +
                              to_double(positions[corners[2]])) *
                             (1.0 / 3.0);
      std::uint64_t key = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double share = std::clamp((centroid[axis] - low[axis]) / largest, 0.0, 1.0);
        key |= spread(static_cast<std::uint64_t>(share * ((1 << kBitsPerAxis) - 1))) << axis;
      }
      keys[t] = {key, static_cast<Index>(t)};
    }
  });
  if (!keyed || !sort_by_code(keys, run)) return run.stop_error();

  tree.order_.resize(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) tree.order_[i] = keys[i].triangle;
  const std::size_t leaves = (triangles.size() + kLeaf - 1) / kLeaf;
  tree.first_leaf_ = std::bit_ceil(std::max<std::size_t>(leaves, 1));
  tree.boxes_.assign(2 * tree.first_leaf_, kNothing);
  const bool boxed = parallel_for(leaves, run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      Box& box = tree.boxes_[tree.first_leaf_ + leaf];
      for (std::size_t i = leaf * kLeaf; i < std::min(keys.size(), (leaf + 1) * kLeaf); ++i) {
        for (const Index v : triangles[tree.order_[i]]) merge(box, {positions[v], positions[v]});
      }
    }
  });
  if (!boxed) return run.stop_error();
  for (std::size_t node = tree.first_leaf_ - 1; node >= 1; --node) {
    for (const std::size_t child : {2 * node, 2 * node + 1}) merge(tree.boxes_[node], tree.boxes_[child]);
  }
  return tree;
}

double NearestTriangle::to_triangle(const Vec3d& point, Index triangle) const {
  const Triangle& t = triangles_[triangle];
  return squared_distance(point, to_double(positions_[t[0]]), to_double(positions_[t[1]]),
                          to_double(positions_[t[2]]));
}

double NearestTriangle::to_box(const Vec3d& point, std::size_t node) const {
  const Box& box = boxes_[node];
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double outside = std::max({box.low[axis] - point[axis], point[axis] - box.high[axis], 0.0});
    sum += outside * outside;
  }
  return sum;
}

NearestTriangle::Hit NearestTriangle::find(const Vec3d& point, Index start) const {
  Hit best{to_triangle(point, start), start};
  std::pair<double, std::size_t> stack[64];  // two per level of a heap of at most 2^30 leaves
  std::size_t depth = 0;
  stack[depth++] = {to_box(point, 1), 1};
  while (depth > 0) {
    const auto [distance, node] = stack[--depth];
    if (distance >= best.squared_distance) continue;
    if (node >= first_leaf_) {
      const std::size_t begin = (node - first_leaf_) * kLeaf;
      for (std::size_t i = begin; i < std::min(order_.size(), begin + kLeaf); ++i) {
        const double candidate = to_triangle(point, order_[i]);
        if (candidate < best.squared_distance) best = {candidate, order_[i]};
      }
      continue;
    }
    std::pair<double, std::size_t> near{to_box(point, 2 * node), 2 * node};
    std::pair<double, std::size_t> far{to_box(point, 2 * node + 1), 2 * node + 1};
    if (far.first < near.first) std::swap(near, far);
    if (far.first < best.squared_distance) stack[depth++] = far;
    if (near.first < best.squared_distance) stack[depth++] = near;
  }
  return best;
}

}  // namespace burnish
