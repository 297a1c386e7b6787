#include <algorithm>
#include <cmath>

#include "tests/support/facets.h"

namespace burnish::testing {
namespace {

double distance(const Point2& a, const Point2& b) { return std::hypot(b.x - a.x, b.y - a.y); }
Point2 between(const Point2& a, const Point2& b, double t) {
  return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
}
Vec3d around(double radius, double angle, double z) {
  return {radius * portable_cos(angle), radius * portable_sin(angle), z};
}

using Cuts = std::vector<double>;

/// The four sides of a rectangle of width 1 and height 1, each cut as given, scaled.
Loop rectangle(double width, double height, const Cuts& low, const Cuts& right, const Cuts& high,
               const Cuts& left) {
  Loop loop;
  for (std::size_t i = 0; i + 1 < low.size(); ++i) loop.push_back({width * low[i], 0});
  for (std::size_t i = 0; i + 1 < right.size(); ++i) loop.push_back({width, height * right[i]});
  for (std::size_t i = high.size() - 1; i > 0; --i) loop.push_back({width * high[i], height});
  for (std::size_t i = left.size() - 1; i > 0; --i) loop.push_back({0, height * left[i]});
  return loop;
}

bool on_axis(const Point2& p) { return p.x < 1e-9; }

/// A profile's circle is cut once; both stretches at it, and a stretch's two ends, use the same cuts.
class Revolver {
 public:
  Revolver(double edge, Random& random) : mesher_(edge, random) {}

  void turn(const Stretch& s, const Cuts& low, const Cuts& high) {
    const Point2 from = s.at(0), to = s.at(1);
    if (std::abs(from.y - to.y) < 1e-9) return turn_flat(from, to, low, high);
    if (on_axis(from) || on_axis(to)) return turn_cone(s, low, high);
    const Cuts along = mesher_.cuts([&](double t) { return around(s.at(t).x, 0, s.at(t).y); }, s.least);
    const double width = kPi * (from.x + to.x);
    // Along the circle is x, along the profile y: what was counter-clockwise outside stays so.
    mesher_.add({rectangle(width, s.length, low, along, high, along)}, [&](const Point2& p) {
      const Point2 at = s.at(p.y / s.length);
      return around(at.x, 2 * kPi * p.x / width, at.y);
    });
  }

  Cuts circle(const Point2& p) {
    if (on_axis(p)) return {};
    return mesher_.cuts([&](double t) { return around(p.x, 2 * kPi * t, p.y); }, 6);
  }

  Shape finish() { return mesher_.finish(); }

 private:
  void turn_flat(const Point2& from, const Point2& to, const Cuts& low, const Cuts& high) {
    std::vector<Loop> loops;
    if (!on_axis(from)) loops.push_back(circle_loop(from.x, low));
    if (!on_axis(to)) loops.push_back(circle_loop(to.x, high));
    mesher_.add(
        loops,
        [&](const Point2& p) {
          return Vec3d{p.x, p.y, from.y};
        },
        from.x < to.x);
  }

  /// Pressed flat around its tip, which is a loop of one point; between the length of its side and its radius
  /// in size.
  void turn_cone(const Stretch& s, const Cuts& low, const Cuts& high) {
    const bool tip_first = on_axis(s.at(0));
    const Point2 tip = s.at(tip_first ? 0 : 1), rim = s.at(tip_first ? 1 : 0);
    const double radius = (s.length + rim.x) / 2;
    const auto place = [&](const Point2& p) {
      const double out = std::hypot(p.x, p.y) / radius;
      return Vec3d{p.x * rim.x / radius, p.y * rim.x / radius, tip.y + (rim.y - tip.y) * out};
    };
    mesher_.add({circle_loop(radius, tip_first ? high : low), {{0, 0}}}, place, tip_first);
  }

  static Loop circle_loop(double radius, const Cuts& cuts) {
    Loop loop;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const Vec3d p = around(radius, 2 * kPi * cuts[i], 0);
      loop.push_back({p.x, p.y});
    }
    return loop;
  }

  FacetMesher mesher_;
};

std::vector<Vec3d> clipped(const std::vector<Vec3d>& outline, const HalfSpace& plane) {
  std::vector<Vec3d> kept;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3d a = outline[i], b = outline[(i + 1) % outline.size()];
    const double over_a = dot(a, plane.normal) - plane.distance,
                 over_b = dot(b, plane.normal) - plane.distance;
    if (over_a <= 0) kept.push_back(a);
    if ((over_a <= 0) != (over_b <= 0)) kept.push_back(a + (b - a) * (over_a / (over_a - over_b)));
  }
  return kept;
}

/// Two unit vectors that with the normal are right-handed.
std::array<Vec3d, 2> axes_of(const Vec3d& normal) {
  const Vec3d aside = std::abs(normal.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  Vec3d u = cross(aside, normal);
  u *= 1 / length(u);
  return {u, cross(normal, u)};
}

}  // namespace

Stretch line(Point2 from, Point2 to) {
  return {[=](double t) { return between(from, to, t); }, distance(from, to)};
}

Stretch arc(Point2 centre, double radius, double from, double to) {
  const auto at = [=](double t) {
    const Vec3d p = around(radius, from + (to - from) * t, 0);
    return Point2{centre.x + p.x, centre.y + p.y};
  };
  return {at, radius * std::abs(to - from), 2};
}

std::vector<Stretch> polygon(const std::vector<Point2>& corners) {
  return rounded_polygon(corners, std::vector<double>(corners.size()));
}

std::vector<Stretch> rounded_polygon(const std::vector<Point2>& corners, const std::vector<double>& radii) {
  const std::size_t n = corners.size();
  std::vector<Stretch> profile;
  const auto cut_off = [&](std::size_t i) {  // what rounding takes from each side of corner i
    const Point2 p = corners[i], a = corners[(i + n - 1) % n], b = corners[(i + 1) % n];
    const double ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y;
    const double opening = portable_angle(std::abs(ax * by - ay * bx), ax * bx + ay * by);
    return radii[i] * portable_cos(opening / 2) / portable_sin(opening / 2);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    const Point2 p = corners[i], q = corners[next], r = corners[(i + 2) % n];
    const double side = distance(p, q), off = cut_off(next);
    const Point2 from = between(p, q, cut_off(i) / side), to = between(q, p, off / side);
    profile.push_back(line(from, to));
    if (radii[next] <= 0) continue;
    const Point2 end = between(q, r, off / distance(q, r));
    const double turn = (q.x - p.x) * (r.y - q.y) - (q.y - p.y) * (r.x - q.x) > 0 ? 1 : -1;
    const Point2 out = {turn * (q.y - p.y) / side, turn * (p.x - q.x) / side};  // from the centre to `to`
    const Point2 centre = {to.x - radii[next] * out.x, to.y - radii[next] * out.y};
    const double ex = (end.x - centre.x) / radii[next], ey = (end.y - centre.y) / radii[next];
    const double sweep = turn * portable_angle(std::abs(out.x * ey - out.y * ex), out.x * ex + out.y * ey);
    const double start = out.y >= 0 ? portable_angle(out.y, out.x) : -portable_angle(-out.y, out.x);
    profile.push_back(arc(centre, radii[next], start, start + sweep));
  }
  return profile;
}

Shape extrusion(const std::vector<std::vector<Stretch>>& outlines, double bottom, double top, double edge,
                Random& random, const std::function<double(const Point2&)>& relief) {
  FacetMesher mesher(edge, random);
  std::vector<Loop> low_loops, high_loops;
  for (const auto& outline : outlines) {
    std::vector<Cuts> upright;  // where each stretch begins
    for (const Stretch& s : outline) {
      const Point2 p = s.at(0);
      upright.push_back(mesher.cuts([&](double t) { return Vec3d{p.x, p.y, bottom + (top - bottom) * t}; }));
    }
    Loop low_loop, high_loop;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Stretch& s = outline[i];
      const auto rim = [&](double z) {
        return mesher.cuts([&](double t) { return Vec3d{s.at(t).x, s.at(t).y, z}; }, s.least);
      };
      const Cuts low = rim(bottom), high = rim(top);
      for (std::size_t k = 0; k + 1 < low.size(); ++k) low_loop.push_back(s.at(low[k]));
      for (std::size_t k = 0; k + 1 < high.size(); ++k) high_loop.push_back(s.at(high[k]));
      mesher.add(
          {rectangle(s.length, top - bottom, low, upright[(i + 1) % outline.size()], high, upright[i])},
          [&](const Point2& p) {
            const Point2 at = s.at(p.x / s.length);
            return Vec3d{at.x, at.y, bottom + p.y};
          });
    }
    low_loops.push_back(low_loop);
    high_loops.push_back(high_loop);
  }
  mesher.add(
      low_loops,
      [&](const Point2& p) {
        return Vec3d{p.x, p.y, bottom};
      },
      true);
  mesher.add(high_loops, [&](const Point2& p) { return Vec3d{p.x, p.y, top + (relief ? relief(p) : 0)}; });
  return mesher.finish();
}

Shape revolution(const std::vector<Stretch>& profile, double edge, Random& random) {
  Revolver revolver(edge, random);
  Cuts low = revolver.circle(profile.front().at(0));
  for (const Stretch& s : profile) {
    const Cuts high = revolver.circle(s.at(1));
    revolver.turn(s, low, high);
    low = high;
  }
  return revolver.finish();
}

std::vector<std::vector<Vec3d>> sides_of(const std::vector<HalfSpace>& planes) {
  constexpr double kFar = 10;
  std::vector<std::vector<Vec3d>> sides;
  for (const HalfSpace& plane : planes) {
    const auto [u, v] = axes_of(plane.normal);
    const Vec3d o = plane.normal * plane.distance;
    std::vector<Vec3d> side = {o - (u + v) * kFar, o + (u - v) * kFar, o + (u + v) * kFar,
                               o + (v - u) * kFar};
    for (const HalfSpace& other : planes) {
      if (&other != &plane) side = clipped(side, other);
    }
    sides.push_back(side);
  }
  return sides;
}

Shape convex_solid(const std::vector<HalfSpace>& planes, double edge, Random& random) {
  FacetMesher mesher(edge, random);
  const auto sides = sides_of(planes);
  using Key = std::array<long long, 3>;
  const auto key = [](const Vec3d& p) {
    return Key{std::llround(p.x * 1e7), std::llround(p.y * 1e7), std::llround(p.z * 1e7)};
  };
  std::map<std::pair<Key, Key>, std::vector<Vec3d>> edges;  // by their ends, cut when first met
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (sides[i].size() < 3) continue;
    const auto [u, v] = axes_of(planes[i].normal);
    const Vec3d origin = sides[i][0];
    Loop loop;
    for (std::size_t k = 0; k < sides[i].size(); ++k) {
      const Vec3d a = sides[i][k], b = sides[i][(k + 1) % sides[i].size()];
      std::vector<Vec3d>& points = edges[{key(a), key(b)}];
      if (const auto twin = edges.find({key(b), key(a)}); twin != edges.end() && !twin->second.empty()) {
        points.assign(twin->second.rbegin(), twin->second.rend());
      } else {
        for (const double t : mesher.cuts([&](double s) { return a + (b - a) * s; }))
          points.push_back(a + (b - a) * t);
      }
      for (std::size_t j = 0; j + 1 < points.size(); ++j) {
        loop.push_back({dot(points[j] - origin, u), dot(points[j] - origin, v)});
      }
    }
    mesher.add({loop}, [&](const Point2& p) { return origin + u * p.x + v * p.y; });
  }
  return mesher.finish();
}

}  // namespace burnish::testing
