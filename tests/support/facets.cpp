#include "tests/support/facets.h"

#include <algorithm>
#include <cmath>

namespace burnish::testing {
namespace {

/// Distances between random points and from them to outlines, in edges: gives triangles of the asked size.
constexpr double kApart = 0.78, kFromOutline = 0.55;
constexpr double kSmallest = 0.7, kLargest = 1.43;  // of size_at()

bool inside(const std::vector<Loop>& loops, const Point2& p) {
  bool odd = false;
  for (const Loop& loop : loops) {
    for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
      const Point2 a = loop[i], b = loop[j];
      if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) odd = !odd;
    }
  }
  return odd;
}

struct Box2 {
  Point2 low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};
};

Box2 box_of(const std::vector<Loop>& loops) {
  Box2 box;
  for (const Loop& loop : loops) {
    for (const Point2& p : loop) {
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y)};
    }
  }
  return box;
}

/// Discs that keep others away, in square cells.
class Discs {
 public:
  Discs(const Box2& box, double most) : low_(box.low), cell_(most) {
    columns_ = static_cast<int>((box.high.x - box.low.x) / cell_) + 3;
    rows_ = static_cast<int>((box.high.y - box.low.y) / cell_) + 3;
    cells_.resize(static_cast<std::size_t>(columns_) * rows_);
  }

  void add(const Point2& p, double radius) { cells_[at(column(p.x), row(p.y))].push_back({p, radius}); }

  /// No disc holds p, and one of this radius around p holds no centre of a disc of its kind.
  bool clear(const Point2& p) const {
    for (int i = column(p.x) - 1; i <= column(p.x) + 1; ++i) {
      for (int j = row(p.y) - 1; j <= row(p.y) + 1; ++j) {
        for (const auto& [centre, radius] : cells_[at(i, j)]) {
          const double dx = p.x - centre.x, dy = p.y - centre.y;
          if (dx * dx + dy * dy < radius * radius) return false;
        }
      }
    }
    return true;
  }

 private:
  struct Disc {
    Point2 centre;
    double radius;
  };
  int column(double x) const { return static_cast<int>((x - low_.x) / cell_) + 1; }
  int row(double y) const { return static_cast<int>((y - low_.y) / cell_) + 1; }
  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j) * columns_ + i; }

  Point2 low_;
  double cell_;
  int columns_, rows_;
  std::vector<std::vector<Disc>> cells_;
};

}  // namespace

FacetMesher::FacetMesher(double edge, Random& random)
    : edge_(edge), random_(random), wave_(random.direction() * 4), phase_(random.between(0, 2 * kPi)) {}

double FacetMesher::size_at(const Vec3d& p) const {
  return portable_exp(0.35 * portable_cos(dot(wave_, p) + phase_));
}

std::vector<double> FacetMesher::cuts(const std::function<Vec3d(double)>& curve, int least) {
  constexpr int kSteps = 400;
  std::vector<double> way = {0};  // in edges, up to each step
  Vec3d last = curve(0);
  for (int i = 1; i <= kSteps; ++i) {
    const Vec3d next = curve(static_cast<double>(i) / kSteps);
    way.push_back(way.back() + length(next - last) / (edge_ * size_at(next)));
    last = next;
  }
  const int pieces = std::max(least, static_cast<int>(std::lround(way.back())));
  std::vector<double> at = {0};
  for (int i = 1; i < pieces; ++i) {
    const double wanted = way.back() * (i + random_.between(-0.2, 0.2)) / pieces;
    const auto after = std::ranges::lower_bound(way, wanted);
    const double part = (wanted - *(after - 1)) / (*after - *(after - 1));
    at.push_back((static_cast<double>(after - way.begin()) - 1 + part) / kSteps);
  }
  at.push_back(1);
  return at;
}

std::vector<Point2> FacetMesher::fill(const std::vector<Loop>& loops,
                                      const std::function<Vec3d(const Point2&)>& place) {
  const Box2 box = box_of(loops);
  Discs discs(box, kApart * kLargest * edge_);
  std::vector<Point2> points;
  for (const Loop& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Point2 a = loop[i], b = loop[(i + 1) % loop.size()];
      points.push_back(a);
      for (int part = 0; part < 4; ++part) {
        const Point2 p = {a.x + (b.x - a.x) * part / 4, a.y + (b.y - a.y) * part / 4};
        discs.add(p, kFromOutline * edge_ * size_at(place(a)));
      }
    }
  }
  const double width = box.high.x - box.low.x, height = box.high.y - box.low.y;
  const auto tries = static_cast<int>(15 * width * height / (edge_ * edge_ * kSmallest * kSmallest)) + 20;
  for (int i = 0; i < tries; ++i) {
    const Point2 p = {box.low.x + width * random_.unit(), box.low.y + height * random_.unit()};
    if (!discs.clear(p) || !inside(loops, p)) continue;
    points.push_back(p);
    discs.add(p, kApart * edge_ * size_at(place(p)));
  }
  return points;
}

Index FacetMesher::vertex_at(const Vec3d& p) {
  const auto rounded = [](double x) { return std::llround(x * 1e7); };
  const auto [at, added] = vertices_.try_emplace({rounded(p.x), rounded(p.y), rounded(p.z)},
                                                 static_cast<Index>(shape_.positions.size()));
  if (added) shape_.positions.push_back(p);
  return at->second;
}

void FacetMesher::add(const std::vector<Loop>& loops, const std::function<Vec3d(const Point2&)>& place,
                      bool flipped) {
  const std::vector<Point2> points = fill(loops, place);
  std::vector<Index> vertex_of;
  for (const Point2& p : points) vertex_of.push_back(vertex_at(place(p)));
  for (const auto& [a, b, c] : delaunay(points)) {
    const Point2 middle = {(points[a].x + points[b].x + points[c].x) / 3,
                           (points[a].y + points[b].y + points[c].y) / 3};
    if (!inside(loops, middle)) continue;
    Triangle t = {vertex_of[a], vertex_of[b], vertex_of[c]};
    if (flipped) std::swap(t[1], t[2]);
    shape_.triangles.push_back(t);
  }
}

Shape FacetMesher::finish() {
  flip_edges(shape_, 0.15, random_);
  return std::move(shape_);
}

}  // namespace burnish::testing
