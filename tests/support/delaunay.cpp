#include "tests/support/delaunay.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace burnish::testing {
namespace {

struct Candidate {
  Triangle corners;
  Point2 centre;
  double squared_radius;
};

Candidate with_circle(const std::vector<Point2>& points, Index a, Index b, Index c) {
  // From a near corner: seen from a far one, which come last, the other two are one place.
  while (a > b || a > c) std::tie(a, b, c) = std::tuple(b, c, a);
  const Point2 o = points[a];
  const double bx = points[b].x - o.x, by = points[b].y - o.y, cx = points[c].x - o.x, cy = points[c].y - o.y;
  const double twice_cross = 2 * (bx * cy - by * cx), bb = bx * bx + by * by, cc = cx * cx + cy * cy;
  const double x = (cy * bb - by * cc) / twice_cross, y = (bx * cc - cx * bb) / twice_cross;
  return {{a, b, c}, {o.x + x, o.y + y}, x * x + y * y};
}

/// Three corners around everything, far enough away to bend the hull by little.
void add_surrounding_triangle(std::vector<Point2>& points) {
  Point2 low = points.front(), high = low;
  for (const Point2& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double far = 2000 * std::max(high.x - low.x, high.y - low.y);
  const Point2 middle = {(low.x + high.x) / 2, (low.y + high.y) / 2};
  points.push_back({middle.x - 2 * far, middle.y - far});
  points.push_back({middle.x + 2 * far, middle.y - far});
  points.push_back({middle.x, middle.y + 2 * far});
}

/// The edges of the hole that the removed triangles leave: those that occur once.
std::vector<std::array<Index, 2>> rim_of(const std::vector<Triangle>& removed) {
  std::vector<std::array<Index, 2>> rim;
  for (const Triangle& t : removed) {
    for (std::size_t e = 0; e < 3; ++e) {
      const auto twin = std::ranges::find(rim, std::array{t[(e + 1) % 3], t[e]});
      if (twin == rim.end()) {
        rim.push_back({t[e], t[(e + 1) % 3]});
      } else {
        rim.erase(twin);
      }
    }
  }
  return rim;
}

}  // namespace

std::vector<Triangle> delaunay(std::span<const Point2> given) {
  const auto count = static_cast<Index>(given.size());
  std::vector<Point2> points(given.begin(), given.end());
  add_surrounding_triangle(points);
  std::vector<Index> order(count);
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(order, {}, [&](Index i) { return points[i].x; });

  std::vector<Triangle> done, removed;
  std::vector<Candidate> open = {with_circle(points, count, count + 1, count + 2)};
  for (const Index v : order) {
    removed.clear();
    std::size_t kept = 0;
    for (const Candidate& candidate : open) {
      const double dx = points[v].x - candidate.centre.x, dy = points[v].y - candidate.centre.y;
      if (dx > 0 && dx * dx > candidate.squared_radius) {
        done.push_back(candidate.corners);  // no later point reaches its circle
      } else if (dx * dx + dy * dy < candidate.squared_radius) {
        removed.push_back(candidate.corners);
      } else {
        open[kept++] = candidate;
      }
    }
    open.erase(open.begin() + static_cast<std::ptrdiff_t>(kept), open.end());
    for (const auto& [a, b] : rim_of(removed)) open.push_back(with_circle(points, a, b, v));
  }
  for (const Candidate& candidate : open) done.push_back(candidate.corners);
  std::erase_if(done, [&](const Triangle& t) { return std::ranges::max(t) >= count; });
  return done;
}

}  // namespace burnish::testing
