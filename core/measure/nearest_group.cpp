#include "core/measure/nearest_group.h"

#include <algorithm>
#include <array>
#include <bit>
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

/// More than the root of the largest square that float takes for 0.
constexpr float kLeastRadius = 2e-19F;

/// All that is within a distance of a point, and a little more.
BURNISH_INLINE Box around(const Floats& p, double squared) {
  const float radius = std::sqrt(static_cast<float>(squared)) + kLeastRadius;
  const Floats slack = ((p < 0.0F ? -p : p) + radius) * 0x1p-21F;  // more than all rounding
  const Floats low = p - radius - slack, high = p + radius + slack;
  Box box;
  box.low = SimdVec3(low > -Box::kFar ? low : Floats{} - Box::kFar);
  box.high = SimdVec3(high < Box::kFar ? high : Floats{} + Box::kFar);
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
    const auto met = (at(node.low[0]) <= box.high.x()) & (at(node.high[0]) >= box.low.x()) &
                     (at(node.low[1]) <= box.high.y()) & (at(node.high[1]) >= box.low.y()) &
                     (at(node.low[2]) <= box.high.z()) & (at(node.high[2]) >= box.low.z());
    Mask quarters[kLanes / 4];
    std::memcpy(quarters, &met, sizeof met);
    for (std::size_t q = 0; q < kLanes / 4; ++q) bits |= bits_of(quarters[q]) << (part + 4 * q);
  }
  return bits;
}

/// Four pairs of a triangle, given by its place in the order, and a point, a pair per lane.
struct Row {
  Floats corners[3][3], point[3];  // by corner and axis

  BURNISH_INLINE void load(const Tree& tree, const std::uint32_t* places) {
    const Triangle* t[kRow];
    for (std::size_t i = 0; i < kRow; ++i) t[i] = &tree.triangles[tree.order[places[i]]];
    for (std::size_t c = 0; c < 3; ++c) {
      Floats rows[kRow];
      for (std::size_t i = 0; i < kRow; ++i) rows[i] = tree.positions[(*t[i])[c]].lanes();
      by_axis(rows, corners[c]);
    }
  }
};

BURNISH_INLINE void join(const Floats (&rows)[1], Floats& to) { to = rows[0]; }
BURNISH_INLINE void join(const Floats (&rows)[2], Wide::Boxes& to) {
  to = __builtin_shufflevector(rows[0], rows[1], 0, 1, 2, 3, 4, 5, 6, 7);
}

/// What float says of a squared distance: surely no less and no more than this.
template <class Boxes>
struct Bounds {
  Boxes low, high;
};

/// For triangles that are neither flat nor much smaller than their distance float is right to a few units in
/// the last place of the lengths that it starts from (each way from a corner rounds once); the slack is a
/// hundred times the largest error of 60 million random ones. Of all others it says nothing.
template <class Boxes>
BURNISH_INLINE void bound(const detail::Wedge<Boxes>& wedge, Bounds<Boxes>& bounds) {
  constexpr float kOfSquare = 0x1p-13F, kOfLengths = 0x1p-20F, kLeastSquaredSine = 0x1p-6F, kMostRatio = 64;
  constexpr float kTiny = 1e-28F, kHuge = 1e30F;  // products of four lengths stay within float
  const Boxes product = wedge.bb * wedge.cc, squared = wedge.squared_to_face();
  const Boxes lengths = detail::dot_of(wedge.p, wedge.p) + wedge.bb + wedge.cc;
  const Boxes slack = squared * kOfSquare + lengths * kOfLengths, zero = wedge.bb - wedge.bb;
  const auto sure = (product - wedge.bc * wedge.bc > product * kLeastSquaredSine) & (product > kTiny) &
                    (product < kHuge) & (lengths <= detail::smaller(wedge.bb, wedge.cc) * kMostRatio);
  bounds.low = sure ? squared - slack : zero;
  bounds.high = sure ? squared + slack : zero + std::numeric_limits<float>::infinity();
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
  std::array<std::uint8_t, 2 * kMostOfPoint / kRow + 1> points;  // by row
  std::size_t count = 0;                                         // of places; whole rows between points

  BURNISH_INLINE bool may_not_hold_another() const { return count > kMostOfPoint; }
  /// The places from `first` on are those of a point.
  BURNISH_INLINE void end_point(std::size_t point, std::size_t first) {
    if (count == first) return;
    std::fill_n(places.begin() + static_cast<std::ptrdiff_t>(count), kRow, places[first]);
    for (; first < count; first += kRow) points[first / kRow] = static_cast<std::uint8_t>(point);
    count = first;
  }
  /// Repeats the last row until they are a multiple of so many.
  BURNISH_INLINE void fill_up(std::size_t rows) {
    for (; count / kRow % rows != 0; count += kRow) {
      std::copy_n(places.begin() + static_cast<std::ptrdiff_t>(count - kRow), kRow,
                  places.begin() + static_cast<std::ptrdiff_t>(count));
      points[count / kRow] = points[count / kRow - 1];
    }
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

/// The points of a group, and the least squared distance seen of each.
struct Group {
  std::size_t count;
  std::array<Floats, kMost> points;
  std::array<double, kMost> least;
};

/// Lowers `least` for four pairs of a point and a triangle, by the exact formula.
template <class Width>
BURNISH_INLINE void see_row(const Tree& tree, const std::uint32_t* places, const std::uint32_t* points,
                            Group& group) {
  using Doubles = typename Width::Doubles;
  constexpr std::size_t kLanes = sizeof(Doubles) / sizeof(double);
  Row row;
  row.load(tree, places);
  const Floats rows[kRow] = {group.points[points[0]], group.points[points[1]], group.points[points[2]],
                             group.points[points[3]]};
  by_axis(rows, row.point);
  for (std::size_t part = 0; part < kRow; part += kLanes) {
    const auto at = [&](const Floats& lanes) {
      if constexpr (kLanes == kRow) {
        return __builtin_convertvector(lanes, Doubles);
      } else {
        return Doubles{lanes[part], lanes[part + 1]};
      }
    };
    const auto point_at = [&](const Floats(&a)[3]) __attribute__((always_inline)) {
      return Vec3<Doubles>{at(a[0]), at(a[1]), at(a[2])};
    };
    const detail::Wedge<Doubles> wedge(point_at(row.point), point_at(row.corners[0]),
                                       point_at(row.corners[1]), point_at(row.corners[2]));
    Doubles squared = wedge.squared_to_face();
    const auto flat = wedge.is_flat();
    std::int64_t any_flat = 0;
    for (std::size_t i = 0; i < kLanes; ++i) any_flat |= flat[i];
    if (any_flat != 0) squared = flat ? wedge.squared_to_flat() : squared;
    for (std::size_t i = 0; i < kLanes; ++i) {
      double& least = group.least[points[part + i]];
      least = std::min(least, squared[i]);
    }
  }
}

/// Lowers `least` by all hits: float tells which triangles may be a point's nearest, mostly one or two, and
/// only these are asked for exactly.
template <class Width>
BURNISH_INLINE void see(const Tree& tree, Hits& hits, Group& group) {
  using Boxes = typename Width::Boxes;
  constexpr std::size_t kLanes = sizeof(Boxes) / sizeof(float), kRows = kLanes / kRow;
  hits.fill_up(kRows);
  std::array<float, Hits::kMostOfPoint * 2 + Node::kWidth> lows;
  std::array<Floats, kMost> highs;
  std::fill_n(highs.begin(), group.count, Floats{} + std::numeric_limits<float>::infinity());
  for (std::size_t h = 0; h < hits.count; h += kLanes) {
    Row rows[kRows];
    for (std::size_t r = 0; r < kRows; ++r) {
      rows[r].load(tree, &hits.places[h + r * kRow]);
      const Floats& p = group.points[hits.points[h / kRow + r]];
      for (std::size_t axis = 0; axis < 3; ++axis) rows[r].point[axis] = Floats{} + p[axis];
    }
    Vec3<Boxes> point, corners[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Floats parts[4][kRows];
      for (std::size_t r = 0; r < kRows; ++r) {
        for (std::size_t c = 0; c < 3; ++c) parts[c][r] = rows[r].corners[c][axis];
        parts[3][r] = rows[r].point[axis];
      }
      for (std::size_t c = 0; c < 3; ++c) join(parts[c], corners[c][axis]);
      join(parts[3], point[axis]);
    }
    Bounds<Boxes> bounds;
    bound(detail::Wedge<Boxes>(point, corners[0], corners[1], corners[2]), bounds);
    std::memcpy(&lows[h], &bounds.low, sizeof bounds.low);
    Floats parts[kRows];
    std::memcpy(parts, &bounds.high, sizeof bounds.high);
    for (std::size_t r = 0; r < kRows; ++r) {
      Floats& high = highs[hits.points[h / kRow + r]];
      high = detail::smaller(parts[r], high);
    }
  }
  for (Floats& high : std::span(highs).first(group.count)) {
    const Floats half = detail::smaller(high, __builtin_shufflevector(high, high, 2, 3, 0, 1));
    high = detail::smaller(half, __builtin_shufflevector(half, half, 1, 0, 3, 2));
  }
  std::array<std::uint32_t, Hits::kMostOfPoint * 2 + 2 * Node::kWidth> chosen;  // numbers of hits
  std::size_t count = 0;
  for (std::size_t h = 0; h < hits.count; h += kRow) {
    Floats low;
    std::memcpy(&low, &lows[h], sizeof low);
    const Mask beyond = low > highs[hits.points[h / kRow]];  // not where float says nothing
    count += keep(h, ~bits_of(beyond) & 15U, &chosen[count]);
  }
  for (std::size_t i = 0; i < count; i += kRow) {
    std::uint32_t places[kRow], points[kRow];
    for (std::size_t k = 0; k < kRow; ++k) {
      const std::uint32_t hit = chosen[std::min(i + k, count - 1)];
      places[k] = hits.places[hit];
      points[k] = hits.points[hit / kRow];
    }
    see_row<Width>(tree, places, points, group);
  }
  hits.count = 0;
}

template <class Width>
BURNISH_INLINE bool find_with(const Tree& tree, std::span<const Vec3f> points, std::span<double> squared) {
  std::array<Box, kMost> boxes;
  Group group;
  group.count = points.size();
  std::fill_n(group.least.begin(), group.count, std::numeric_limits<double>::infinity());
  Box all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    group.points[i] = SimdVec3(points[i]).lanes();
    boxes[i] = around(group.points[i], squared[i]);
    all.extend(boxes[i]);
  }
  Near near;
  if (!collect<Width>(tree, all, near)) return false;
  Hits hits;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t first = hits.count;
    add_hits<Width>(tree, near, boxes[i], hits);
    hits.end_point(i, first);
    if (i + 1 == points.size() || hits.may_not_hold_another()) see<Width>(tree, hits, group);
  }
  std::copy_n(group.least.begin(), squared.size(), squared.begin());
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
