#include "core/measure/nearest_group.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/measure/set_bits.h"
#include "core/measure/squared_distance.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// Every function below is inlined into one of two entry points, each compiled for one vector width.
#define BURNISH_INLINE [[gnu::always_inline]] inline

namespace burnish::nearest_group {
namespace {

constexpr std::size_t kRow = 4;  // triangles that are loaded at once
using Floats = SimdVec3::Lanes;
using Mask = std::int32_t __attribute__((vector_size(16)));
using D2 = double __attribute__((vector_size(16)));
using D4 = double __attribute__((vector_size(32)));
struct Narrow {
  using Boxes = Floats;
  using Doubles = D2;
};
struct Wide {
  using Boxes = float __attribute__((vector_size(32)));
  using Doubles = D4;
};

struct Box {
  static constexpr float kFar = std::numeric_limits<float>::max();
  Vec3f low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
};

/// All that is within a distance of a point, and a little more.
BURNISH_INLINE Box around(const Vec3f& p, double squared) {
  const double radius = std::sqrt(squared);
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slack = 0x1p-22 * (std::abs(p[axis]) + radius) + FLT_MIN;  // more than all rounding
    box.low[axis] = static_cast<float>(std::max<double>(p[axis] - radius - slack, -Box::kFar));
    box.high[axis] = static_cast<float>(std::min<double>(p[axis] + radius + slack, Box::kFar));
  }
  return box;
}

/// First node of the level whose children are triangles.
BURNISH_INLINE std::size_t lowest_level(const Tree& tree) { return (tree.first_triangle - 1) / Node::kWidth; }

/// Bit k: lane k is set.
BURNISH_INLINE unsigned bits_of(const Mask& mask) {
#if defined(__x86_64__)
  return static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask)));
#else
  return (mask[0] & 1U) | (mask[1] & 2U) | (mask[2] & 4U) | (mask[3] & 8U);
#endif
}

/// Bit k: child k's box meets `box`.
template <class Width>
BURNISH_INLINE unsigned children_meeting(const Box& box, const Node& node) {
  using Boxes = typename Width::Boxes;
  constexpr std::size_t kLanes = sizeof(Boxes) / sizeof(float);
  unsigned bits = 0;
  for (std::size_t part = 0; part < Node::kWidth; part += kLanes) {
    const auto at = [&](const float* lanes) {
      Boxes values;
      std::memcpy(&values, lanes + part, sizeof values);
      return values;
    };
    const auto met = (at(node.low[0]) <= box.high.x) & (at(node.high[0]) >= box.low.x) &
                     (at(node.low[1]) <= box.high.y) & (at(node.high[1]) >= box.low.y) &
                     (at(node.low[2]) <= box.high.z) & (at(node.high[2]) >= box.low.z);
    Mask quarters[kLanes / 4];
    std::memcpy(quarters, &met, sizeof met);
    for (std::size_t q = 0; q < kLanes / 4; ++q) bits |= bits_of(quarters[q]) << (part + 4 * q);
  }
  return bits;
}

/// Lowers `least` by the squared distances to four triangles, given by their places in the order.
template <class Width>
BURNISH_INLINE void see_row(const Tree& tree, const Vec3f& p, const std::uint32_t* row,
                            typename Width::Doubles& least) {
  using Doubles = typename Width::Doubles;
  constexpr std::size_t kLanes = sizeof(Doubles) / sizeof(double);
  Floats corners[3][3];  // by corner and axis, a triangle per lane
  const Triangle* t[kRow];
  for (std::size_t i = 0; i < kRow; ++i) t[i] = &tree.triangles[tree.order[row[i]]];
  for (std::size_t c = 0; c < 3; ++c) {
    const Floats p0 = tree.positions[(*t[0])[c]].lanes(), p1 = tree.positions[(*t[1])[c]].lanes(),
                 p2 = tree.positions[(*t[2])[c]].lanes(), p3 = tree.positions[(*t[3])[c]].lanes();
    const Floats xy01 = __builtin_shufflevector(p0, p1, 0, 4, 1, 5),
                 xy23 = __builtin_shufflevector(p2, p3, 0, 4, 1, 5),
                 z01 = __builtin_shufflevector(p0, p1, 2, 6, 3, 7),
                 z23 = __builtin_shufflevector(p2, p3, 2, 6, 3, 7);
    corners[c][0] = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5);
    corners[c][1] = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7);
    corners[c][2] = __builtin_shufflevector(z01, z23, 0, 1, 4, 5);
  }
  const Vec3<Doubles> point{Doubles{} + p.x, Doubles{} + p.y, Doubles{} + p.z};
  for (std::size_t part = 0; part < kRow; part += kLanes) {
    const auto at = [&](const Floats& lanes) {
      // Lane by lane the compiler makes one instruction of it, of __builtin_convertvector three.
      if constexpr (kLanes == kRow) {
        return Doubles{lanes[0], lanes[1], lanes[2], lanes[3]};
      } else {
        return Doubles{lanes[part], lanes[part + 1]};
      }
    };
    Vec3<Doubles> corner[3];
    for (std::size_t c = 0; c < 3; ++c) corner[c] = {at(corners[c][0]), at(corners[c][1]), at(corners[c][2])};
    const detail::Wedge<Doubles> wedge(point, corner[0], corner[1], corner[2]);
    Doubles squared = wedge.squared_to_face();
    const auto flat = wedge.is_flat();
    std::int64_t any_flat = 0;
    for (std::size_t i = 0; i < kLanes; ++i) any_flat |= flat[i];
    if (any_flat != 0) squared = flat ? wedge.squared_to_flat() : squared;
    least = detail::smaller(squared, least);
  }
}

/// Nodes that hold triangles near any point of the group, with their boxes, eight to a row as if they had a
/// parent.
struct Near {
  static constexpr std::size_t kMostRows = 16, kMostNodes = kMostRows * Node::kWidth;
  std::array<Node, kMostRows> rows;
  std::array<std::uint32_t, kMostNodes> nodes;
  std::size_t count = 0;

  BURNISH_INLINE void add(const Node& parent, std::size_t child, std::size_t number) {
    Node& row = rows[count / Node::kWidth];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row.low[axis][count % Node::kWidth] = parent.low[axis][child];
      row.high[axis][count % Node::kWidth] = parent.high[axis][child];
    }
    nodes[count++] = static_cast<std::uint32_t>(number);
  }
  /// Empties what is left of the last row.
  BURNISH_INLINE void finish() {
    for (std::size_t i = count; i % Node::kWidth != 0; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rows[i / Node::kWidth].low[axis][i % Node::kWidth] = Box::kFar;
        rows[i / Node::kWidth].high[axis][i % Node::kWidth] = -Box::kFar;
      }
    }
  }
};

/// Level by level, without a branch on what is met. False when there are too many.
template <class Width>
BURNISH_INLINE bool collect(const Tree& tree, const Box& box, Near& near) {
  const std::size_t lowest = lowest_level(tree);
  if (lowest == 0) return false;
  std::array<std::uint32_t, Near::kMostNodes + Node::kWidth> numbers[2];
  std::uint32_t *parents = numbers[0].data(), *next = numbers[1].data();
  parents[0] = 0;
  std::size_t count = 1;
  for (std::size_t level = 0; level * Node::kWidth + 1 < lowest; level = level * Node::kWidth + 1) {
    std::size_t met = 0;
    for (std::size_t i = 0; i < count && met <= Near::kMostNodes; ++i) {
      const std::size_t node = parents[i];
      met += keep(node * Node::kWidth + 1, children_meeting<Width>(box, tree.nodes[node]), &next[met]);
    }
    if (met > Near::kMostNodes) return false;
    count = met;
    std::swap(parents, next);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Node& parent = tree.nodes[parents[i]];
    const std::size_t first_child = parents[i] * Node::kWidth + 1;
    for (unsigned bits = children_meeting<Width>(box, parent); bits != 0; bits &= bits - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(bits));
      if (first_child + k >= tree.nodes.size()) break;
      if (near.count == Near::kMostNodes) return false;
      near.add(parent, k, first_child + k);
    }
  }
  near.finish();
  return true;
}

/// The hits of several points by rows, to be seen in one long loop: how many rows a point has nobody can
/// foretell, the processor neither.
struct Hits {
  static constexpr std::size_t kMostOfPoint = Near::kMostNodes * Node::kWidth;
  std::array<std::uint32_t, 2 * kMostOfPoint + Node::kWidth> places;
  std::array<std::uint8_t, 2 * kMostOfPoint / kRow> points;  // by row
  std::size_t count = 0;                                     // of places; whole rows between points

  BURNISH_INLINE bool may_not_hold_another() const { return count > kMostOfPoint; }
  /// The places from `first` on are those of a point.
  BURNISH_INLINE void end_point(std::size_t point, std::size_t first) {
    if (count == first) return;
    std::fill_n(places.begin() + static_cast<std::ptrdiff_t>(count), kRow, places[first]);
    for (; first < count; first += kRow) points[first / kRow] = static_cast<std::uint8_t>(point);
    count = first;
  }
};

/// Adds the triangles whose boxes meet `box`.
template <class Width>
BURNISH_INLINE void add_hits(const Tree& tree, const Near& near, const Box& box, Hits& hits) {
  std::array<std::uint32_t, Near::kMostNodes + Node::kWidth> nodes;
  std::size_t count = 0;
  for (std::size_t row = 0; row * Node::kWidth < near.count; ++row) {
    const unsigned met = children_meeting<Width>(box, near.rows[row]);
    count += keep(row * Node::kWidth, met, &nodes[count]);
  }
  const std::size_t lowest = lowest_level(tree);
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t node = near.nodes[nodes[n]];
    const unsigned met = children_meeting<Width>(box, tree.nodes[node]);
    hits.count += keep((node - lowest) * Node::kWidth, met, &hits.places[hits.count]);
  }
}

template <class Width>
BURNISH_INLINE bool find_with(const Tree& tree, std::span<const Vec3f> points, std::span<double> squared) {
  using Doubles = typename Width::Doubles;
  std::array<Box, kMost> boxes;
  std::array<Doubles, kMost> least;
  Box all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    boxes[i] = around(points[i], squared[i]);
    least[i] = Doubles{} + std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.low[axis] = std::min(all.low[axis], boxes[i].low[axis]);
      all.high[axis] = std::max(all.high[axis], boxes[i].high[axis]);
    }
  }
  Near near;
  if (!collect<Width>(tree, all, near)) return false;
  Hits hits;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t first = hits.count;
    add_hits<Width>(tree, near, boxes[i], hits);
    hits.end_point(i, first);
    if (i + 1 < points.size() && !hits.may_not_hold_another()) continue;
    for (std::size_t h = 0; h < hits.count; h += kRow) {
      const std::size_t point = hits.points[h / kRow];
      see_row<Width>(tree, points[point], &hits.places[h], least[point]);
    }
    hits.count = 0;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    squared[i] = least[i][0];
    for (std::size_t k = 1; k < sizeof(Doubles) / sizeof(double); ++k)
      squared[i] = std::min(squared[i], least[i][k]);
  }
  return true;
}

bool find_128(const Tree& tree, std::span<const Vec3f> points, std::span<double> squared) {
  return find_with<Narrow>(tree, points, squared);
}
#if defined(__x86_64__)
[[gnu::target("avx2")]] bool find_256(const Tree& tree, std::span<const Vec3f> points,
                                      std::span<double> squared) {
  return find_with<Wide>(tree, points, squared);
}
#endif

}  // namespace

std::vector<Find> finds_here() {
  std::vector<Find> here{find_128};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) here.push_back(find_256);
#endif
  return here;
}

Find find() {
  static const Find kWidest = finds_here().back();
  return kWidest;
}

}  // namespace burnish::nearest_group
