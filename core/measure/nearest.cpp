#include "core/measure/nearest.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "core/measure/squared_distance.h"
#include "core/mesh/curve.h"
#include "core/run/parallel.h"

namespace burnish {
double squared_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const detail::Wedge<double> wedge(p, a, b, c);
  return wedge.is_flat() ? wedge.squared_to_flat() : wedge.squared_to_face();
}

namespace {

/// Triangles by the place of their middle corner in an order of the vertices, by counting. Not by their
/// first: a fan's triangles may all have the same.
Buffer<Index> triangles_along(std::span<const Index> vertex_order, std::span<const Triangle> triangles,
                              const RunControl& run) {
  const RunControl alone = run.on_one_thread();
  Buffer<Index> place(vertex_order.size()), middle(triangles.size()), order(triangles.size());
  for_each(place.size(), run, [&](std::size_t i) { place[vertex_order[i]] = static_cast<Index>(i); });
  parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Index a = place[triangles[t][0]], b = place[triangles[t][1]], c = place[triangles[t][2]];
      middle[t] = std::max(std::min(a, b), std::min(std::max(a, b), c));
    }
  });
  if (run.stopped()) return order;
  std::vector<Index> next(place.size() + 1);
  for_each(middle.size(), alone, [&](std::size_t t) { ++next[middle[t] + 1]; });
  for_each(place.size(), alone, [&](std::size_t i) { next[i + 1] += next[i]; });
  if (run.stopped()) return order;
  for_each(middle.size(), alone, [&](std::size_t t) { order[next[middle[t]]++] = static_cast<Index>(t); });
  return order;
}

/// Of eight floats, four at a time.
template <class Choose>
float extreme_of(const float (&values)[8], Choose choose) {
  SimdVec3::Lanes low, high;
  std::memcpy(&low, values, sizeof low);
  std::memcpy(&high, values + 4, sizeof high);
  const SimdVec3::Lanes four = choose(low, high);
  const SimdVec3::Lanes two = choose(four, __builtin_shufflevector(four, four, 2, 3, 0, 1));
  return choose(two, __builtin_shufflevector(two, two, 1, 0, 3, 2))[0];
}

}  // namespace

Result<NearestTriangle> NearestTriangle::build(std::span<const Vec3f> positions,
                                               std::span<const Triangle> triangles, const RunControl& run) {
  NearestTriangle tree;
  tree.positions_.resize(positions.size());
  for_each(positions.size(), run, [&](std::size_t v) { tree.positions_[v] = SimdVec3(positions[v]); });
  tree.triangles_ = triangles;
  // Most meshes lie along strips or patches, which makes tighter boxes than any curve through space.
  tree.order_.reserve(triangles.size() + kWidth);
  tree.order_.resize(triangles.size());
  for_each(triangles.size(), run, [&](std::size_t t) { tree.order_[t] = static_cast<Index>(t); });
  if (run.stopped() || !tree.fill(run)) return run.stop_error();
  if (tree.in_good_order()) return tree;
  tree.order_ = triangles_along(curve_order(positions, run), triangles, run);
  if (run.stopped() || !tree.fill(run)) return run.stop_error();
  return tree;
}

/// Whether what lies side by side in memory does so in space: along a strip, a box is as long as its
/// children's together. Asks some of the nodes of the two lowest levels.
bool NearestTriangle::in_good_order() const {
  const std::size_t lowest = (first_triangle_ - 1) / kWidth, above = lowest > 0 ? (lowest - 1) / kWidth : 0;
  const auto is_good = [&](std::size_t begin, std::size_t end, std::size_t step) {
    double whole = 0, parts = 0;
    for (std::size_t node = begin; node < end; node += step) {
      const auto& [low, high] = nodes_[node];
      for (std::size_t k = 0; k < kWidth; ++k) {
        parts += std::max({0.0F, high[0][k] - low[0][k], high[1][k] - low[1][k], high[2][k] - low[2][k]});
      }
      const Box box = box_of_children(node);
      const SimdVec3 size = box.high - box.low;
      whole += std::max({size.x(), size.y(), size.z()});
    }
    return whole <= parts;
  };
  return is_good(lowest, nodes_.size(), 16) && is_good(above, lowest, 4);
}

/// Boxes from the triangles up.
bool NearestTriangle::fill(const RunControl& run) {
  while (order_.size() % kWidth != 0) order_.push_back(order_.back());
  std::size_t level = 0;  // first node of the level whose children are triangles
  for (std::size_t unit = 1; unit * kWidth < order_.size(); unit *= kWidth) level = level * kWidth + 1;
  first_triangle_ = level * kWidth + 1;
  nodes_.resize(level + order_.size() / kWidth);
  const bool done = parallel_for(nodes_.size() - level, run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t node = level + begin; node < level + end; ++node) {
      const Box whole = set_boxes(node, &order_[(node - level) * kWidth]);
      if (node > 0) set_box((node - 1) / kWidth, (node - 1) % kWidth, whole);
    }
  });
  if (!done) return false;
  for (std::size_t node = level; node-- > 0;) {
    for (std::size_t k = 0; k < kWidth; ++k) {
      const std::size_t child = node * kWidth + 1 + k;
      if (child >= nodes_.size()) set_box(node, k, Box());
      if (child < level) set_box(node, k, box_of_children(child));
    }
  }
  return true;
}

void NearestTriangle::set_box(std::size_t node, std::size_t k, const Box& box) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nodes_[node].low[axis][k] = box.low.lanes()[axis];
    nodes_[node].high[axis][k] = box.high.lanes()[axis];
  }
}

/// The boxes of eight triangles, and the one around them.
NearestTriangle::Box NearestTriangle::set_boxes(std::size_t node, const Index* triangles) {
  Box whole;
  for (std::size_t k = 0; k < kWidth; k += 4) {
    SimdVec3::Lanes lows[4], highs[4], low[3], high[3];
    for (std::size_t i = 0; i < 4; ++i) {
      const Box box = box_of(triangles[k + i]);
      lows[i] = box.low.lanes(), highs[i] = box.high.lanes();
      whole.extend(box);
    }
    by_axis(lows, low);
    by_axis(highs, high);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::memcpy(nodes_[node].low[axis] + k, &low[axis], sizeof low[axis]);
      std::memcpy(nodes_[node].high[axis] + k, &high[axis], sizeof high[axis]);
    }
  }
  return whole;
}

NearestTriangle::Box NearestTriangle::box_of_children(std::size_t node) const {
  float low[3], high[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = extreme_of(nodes_[node].low[axis], [](auto a, auto b) { return a < b ? a : b; });
    high[axis] = extreme_of(nodes_[node].high[axis], [](auto a, auto b) { return a > b ? a : b; });
  }
  return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

NearestTriangle::Box NearestTriangle::box_of(Index triangle) const {
  const Triangle& t = triangles_[triangle];
  Box box{positions_[t[0]], positions_[t[0]]};
  for (const Index v : {t[1], t[2]}) box.extend({positions_[v], positions_[v]});
  return box;
}

double NearestTriangle::to_triangle(const Vec3d& point, Index triangle) const {
  const Triangle& t = triangles_[triangle];
  return squared_distance(point, to_double(positions_[t[0]].vec3()), to_double(positions_[t[1]].vec3()),
                          to_double(positions_[t[2]].vec3()));
}

double NearestTriangle::to_box(const Vec3d& point, std::size_t child) const {
  const Node& node = nodes_[(child - 1) / kWidth];
  const std::size_t k = (child - 1) % kWidth;
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = node.low[axis][k], high = node.high[axis][k];
    const double outside = std::max({low - point[axis], point[axis] - high, 0.0});
    sum += outside * outside;
  }
  return sum;
}

/// The children of a node with the squared distances of their boxes.
std::array<NearestTriangle::Entry, NearestTriangle::kWidth> NearestTriangle::entries(
    const Vec3f& p, std::size_t index) const {
  using Lanes = SimdVec3::Lanes;
  constexpr std::size_t kLanes = 4;
  const Node& node = nodes_[index];
  std::array<Entry, kWidth> children;
  for (std::size_t half = 0; half < kWidth; half += kLanes) {
    Lanes sum{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Lanes low, high;
      std::memcpy(&low, node.low[axis] + half, sizeof low);
      std::memcpy(&high, node.high[axis] + half, sizeof high);
      const Lanes below = low - p[axis], above = p[axis] - high;
      Lanes outside = below > above ? below : above;
      outside = outside > 0.0F ? outside : Lanes{};
      sum += outside * outside;
    }
    for (std::size_t k = 0; k < kLanes; ++k) {
      children[half + k] = entry(sum[k], index * kWidth + 1 + half + k);
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

void NearestTriangle::find_all(std::span<const Vec3f> points, std::span<double> squared, Index start,
                               const RunControl& run) const {
  const nearest_group::Tree tree{nodes_, first_triangle_, order_, triangles_, positions_};
  if (points.empty() || nearest_group::find()(tree, points, squared)) return;
  if (run.stopped()) return;  // triangles that overlap make a query slow
  if (points.size() == 1) {
    squared[0] = find(points[0], start).squared_distance;
    return;
  }
  const std::size_t half = points.size() / 2;
  find_all(points.first(half), squared.first(half), start, run);
  find_all(points.subspan(half), squared.subspan(half), start, run);
}

}  // namespace burnish
