#include "core/measure/nearest.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "core/run/parallel.h"

namespace burnish {
namespace {

double squared_length(const Vec3d& v) { return dot(v, v); }

/// To the segment from a to a + along, from the ways that lead from its ends to the point. At an end it is
/// that way's length, so that all triangles around a vertex agree on it.
double squared_to_segment(const Vec3d& from_a, const Vec3d& from_b, const Vec3d& along) {
  const double way = dot(from_a, along), size = squared_length(along);
  if (way <= 0) return squared_length(from_a);
  if (way >= size) return squared_length(from_b);
  return squared_length(from_a - along * (way / size));
}

}  // namespace

double squared_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, bc = c - b, ca = a - c;
  const Vec3d from_a = p - a, from_b = p - b, from_c = p - c;
  const Vec3d normal = cross(ab, bc);
  const double size = squared_length(normal);
  const double outermost = std::min(
      {dot(cross(ab, from_a), normal), dot(cross(bc, from_b), normal), dot(cross(ca, from_c), normal)});
  if (size > 0 && outermost >= 0) {
    const double height = dot(from_a, normal);
    return height * height / size;
  }
  return std::min({squared_to_segment(from_a, from_b, ab), squared_to_segment(from_b, from_c, bc),
                   squared_to_segment(from_c, from_a, ca)});
}

struct NearestTriangle::Box {
  static constexpr float kFar = std::numeric_limits<float>::max();
  Vec3f low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};

  void add(const Vec3f& from, const Vec3f& to) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], from[axis]);
      high[axis] = std::max(high[axis], to[axis]);
    }
  }
};

struct NearestTriangle::Item {
  Vec3f corner_sum;
  Index triangle;

  /// Puts those with the lowest coordinates before `rank`, as std::nth_element does, but by halving the range
  /// of values: no branch depends on an item, which makes it more than twice as fast. What is closer together
  /// than 2^-16 of the range may stay mixed.
  static void select(std::span<Item> items, std::size_t rank, std::size_t axis, float low, float high,
                     const RunControl& run) {
    std::size_t from = 0, to = items.size();
    for (int pass = 0; pass < 16; ++pass) {
      if (to - from > kBlockSize && run.stopped()) return;
      const float pivot = low + (high - low) * 0.5F;
      std::size_t middle = from;
      for (std::size_t i = from; i < to; ++i) {
        const Item item = items[i];
        items[i] = items[middle];
        items[middle] = item;
        middle += item.corner_sum[axis] <= pivot;
      }
      if (middle == rank) return;
      (middle < rank ? from : to) = middle;
      (middle < rank ? low : high) = pivot;
    }
  }

  /// Orders items into runs of `unit` that lie together.
  static void split(std::span<Item> items, std::size_t unit, const RunControl& run) {
    if (items.size() <= unit) return;
    Box box;
    for (const Item& item : items) box.add(item.corner_sum, item.corner_sum);
    const Vec3f extent = box.high - box.low;
    const std::size_t longer = extent.x >= extent.y ? 0 : 1, axis = extent[longer] >= extent.z ? longer : 2;
    const std::size_t runs = (items.size() + unit - 1) / unit, rank = runs / 2 * unit;
    select(items, rank, axis, box.low[axis], box.high[axis], run);
    split(items.first(rank), unit, run);
    split(items.subspan(rank), unit, run);
  }
};

Result<NearestTriangle> NearestTriangle::build(std::span<const Vec3f> positions,
                                               std::span<const Triangle> triangles, const RunControl& run) {
  NearestTriangle tree;
  tree.positions_ = positions;
  tree.triangles_ = triangles;
  std::vector<Item> items(triangles.size());
  parallel_for(items.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c] = triangles[t];
      items[t] = {positions[a] + positions[b] + positions[c], static_cast<Index>(t)};
    }
  });
  std::size_t lowest_node = 0;  // first of the level whose children are triangles
  std::size_t unit = 1;         // triangles per child of the root
  for (; unit * kWidth < items.size(); unit *= kWidth) lowest_node = lowest_node * kWidth + 1;
  tree.first_triangle_ = lowest_node * kWidth + 1;
  tree.nodes_.resize(lowest_node + items.size() / kWidth + 1);
  tree.grow(0, items, unit, run);
  tree.order_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) tree.order_[i] = items[i].triangle;
  if (run.stopped()) return run.stop_error();
  return tree;
}

/// Fills a node and all below it; each child holds `unit` triangles, the last ones fewer or none.
NearestTriangle::Box NearestTriangle::grow(std::size_t node, std::span<Item> items, std::size_t unit,
                                           const RunControl& run) {
  Box all;
  if (items.size() > kBlockSize && run.stopped()) return all;
  if (unit > 1) Item::split(items, unit, run);
  for (std::size_t k = 0; k < kWidth; ++k) {
    Box box;
    if (k * unit < items.size()) {
      const auto part = items.subspan(k * unit, std::min(unit, items.size() - k * unit));
      box = unit > 1 ? grow(node * kWidth + 1 + k, part, unit / kWidth, run) : box_of(part.front().triangle);
    }
    all.add(box.low, box.high);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      nodes_[node].low[axis][k / kLanes][k % kLanes] = box.low[axis];
      nodes_[node].high[axis][k / kLanes][k % kLanes] = box.high[axis];
    }
  }
  return all;
}

NearestTriangle::Box NearestTriangle::box_of(Index triangle) const {
  Box box;
  for (const Index v : triangles_[triangle]) box.add(positions_[v], positions_[v]);
  return box;
}

double NearestTriangle::to_triangle(const Vec3d& point, Index triangle) const {
  const Triangle& t = triangles_[triangle];
  return squared_distance(point, to_double(positions_[t[0]]), to_double(positions_[t[1]]),
                          to_double(positions_[t[2]]));
}

double NearestTriangle::to_box(const Vec3d& point, std::size_t child) const {
  const Node& node = nodes_[(child - 1) / kWidth];
  const std::size_t k = (child - 1) % kWidth;
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = node.low[axis][k / kLanes][k % kLanes], high = node.high[axis][k / kLanes][k % kLanes];
    const double outside = std::max({low - point[axis], point[axis] - high, 0.0});
    sum += outside * outside;
  }
  return sum;
}

/// The children of a node with the squared distances of their boxes.
std::array<NearestTriangle::Entry, NearestTriangle::kWidth> NearestTriangle::entries(
    const Vec3f& p, std::size_t index) const {
  const Node& node = nodes_[index];
  std::array<Entry, kWidth> children;
  for (std::size_t half = 0; half < kWidth / kLanes; ++half) {
    Lanes sum{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Lanes below = node.low[axis][half] - p[axis], above = p[axis] - node.high[axis][half];
      Lanes outside = below > above ? below : above;
      outside = outside > 0.0F ? outside : Lanes{};
      sum += outside * outside;
    }
    for (std::size_t k = 0; k < kLanes; ++k) {
      children[half * kLanes + k] = entry(sum[k], index * kWidth + 1 + half * kLanes + k);
    }
  }
  return children;
}

NearestTriangle::Hit NearestTriangle::find(const Vec3f& p, Index start) const {
  const Vec3d point = to_double(p);
  Hit best;
  // Boxes are compared in float. What rounding may have put on the wrong side is asked again in double.
  constexpr double kRounding = 1e-6, kUnderflow = 1e-37;
  Entry surely_nearer = 0, surely_farther = 0;
  const auto improve = [&](const Hit& hit) {
    best = hit;
    surely_nearer = entry(static_cast<float>(hit.squared_distance * (1 - kRounding)), 0);
    surely_farther = entry(static_cast<float>(hit.squared_distance * (1 + kRounding) + kUnderflow), 0);
  };
  const auto nearer = [&](Entry e) {
    return e < surely_nearer || (e < surely_farther && to_box(point, child_of(e)) < best.squared_distance);
  };
  improve({to_triangle(point, start), start});

  std::array<Entry, kWidth * 12> stack;  // a node leaves at most seven children waiting, on at most 11 levels
  std::size_t depth = 0;
  for (Entry next = entry(0, 0);;) {
    if (child_of(next) < first_triangle_) {
      const auto children = entries(p, child_of(next));
      next = *std::min_element(children.begin(), children.end());
      for (const Entry e : children) {
        stack[depth] = e;
        depth += (e < surely_farther) & (e != next);
      }
    } else {
      const Index triangle = order_[child_of(next) - first_triangle_];
      const double candidate = triangle == start ? best.squared_distance : to_triangle(point, triangle);
      if (candidate < best.squared_distance) improve({candidate, triangle});
      next = surely_farther;
    }
    while (!nearer(next)) {
      if (depth == 0) return best;
      next = stack[--depth];
    }
  }
}

}  // namespace burnish
