#include <algorithm>
#include <cmath>

#include "tests/support/facets.h"
#include "tests/support/procedural_kinds.h"

namespace burnish::testing {
namespace {

/// A full turn, clockwise for a hole.
std::vector<Stretch> circle(Point2 centre, double radius, bool hole) {
  Stretch turn = hole ? arc(centre, radius, 2 * kPi, 0) : arc(centre, radius, 0, 2 * kPi);
  turn.least = 12;
  return {turn};
}

/// A profile for revolution() from corners that begin and end on the axis.
std::vector<Stretch> lathe_profile(const std::vector<Point2>& corners, const std::vector<double>& radii) {
  auto profile = rounded_polygon(corners, radii);
  profile.pop_back();  // the way back along the axis
  return profile;
}

std::vector<Point2> star_corners(Random& random) {
  const int points = random.whole(5, 7);
  const double inner = random.between(0.55, 0.7);
  std::vector<Point2> corners;
  for (int i = 0; i < 2 * points; ++i) {
    const double radius = i % 2 == 0 ? 1 : inner, angle = kPi * i / points;
    corners.push_back({radius * portable_cos(angle), radius * portable_sin(angle)});
  }
  return corners;
}

/// Directions at least 42 degrees from each other, as many as fit.
std::vector<HalfSpace> random_planes(Random& random) {
  std::vector<HalfSpace> planes;
  for (int i = 0; i < 1000; ++i) {
    const Vec3d n = random.direction();
    const bool apart =
        std::ranges::all_of(planes, [&](const HalfSpace& p) { return dot(p.normal, n) < 0.74; });
    if (apart) planes.push_back({n, random.between(0.85, 1)});
  }
  return planes;
}

/// Every plane cuts a side without short edges or acute corners.
bool is_well_cut(const std::vector<HalfSpace>& planes, double shortest, double smallest_cosine) {
  for (const auto& side : sides_of(planes)) {
    if (side.size() < 3) return false;
    for (std::size_t i = 0; i < side.size(); ++i) {
      const Vec3d a = side[(i + 1) % side.size()] - side[i],
                  b = side[(i + side.size() - 1) % side.size()] - side[i];
      if (length(a) < shortest || dot(a, b) > smallest_cosine * length(a) * length(b)) return false;
    }
  }
  return true;
}

}  // namespace

Shape chamfered_box(double edge, Random& random) {
  const double size[] = {random.between(0.5, 1), random.between(0.5, 1), random.between(0.6, 1)};
  std::vector<HalfSpace> planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vec3d normal;
      normal[axis] = sign;
      planes.push_back({normal, size[axis]});
    }
  }
  const Vec3d tilted = {random.between(-0.3, 0.3), random.between(-0.3, 0.3), 1};
  planes.back().normal = tilted * (1 / length(tilted));
  planes.back().distance *= 0.8;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      if (x * y > 0 && random.chance(0.4)) continue;
      const double width = random.between(0.12, 0.3);
      planes.push_back({Vec3d{x, y, 0} * std::sqrt(0.5), (size[0] + size[1] - width) * std::sqrt(0.5)});
    }
  }
  return convex_solid(planes, edge, random);
}

Shape stairs(double edge, Random& random) {
  const int steps = random.whole(3, 5);
  std::vector<Point2> corners = {{-1, -0.8}, {1, -0.8}};
  for (int i = 0; i < steps; ++i) {
    const double x = 1 - 1.7 * i / steps, next = 1 - 1.7 * (i + random.between(0.8, 1.2)) / steps;
    const double y = -0.8 + 1.6 * (i + 1) / steps;
    corners.push_back({i == 0 ? x : corners.back().x, y});
    corners.push_back({i == steps - 1 ? -1 : next, y});
  }
  return extrusion({polygon(corners)}, -random.between(0.4, 0.7), 0.5, edge, random);
}

Shape star_prism(double edge, Random& random) {
  const auto corners = star_corners(random);
  return extrusion({polygon(corners)}, -random.between(0.2, 0.6), 0.3, edge, random);
}

Shape bracket(double edge, Random& random) {
  const double thick = random.between(0.3, 0.5), inner = random.between(0.05, 0.25);
  const double high = random.between(0.4, 0.9);
  const std::vector<Point2> corners = {{-1, -1},          {1, -1},   {1, thick - 1}, {thick - 1, thick - 1},
                                       {thick - 1, high}, {-1, high}};
  const double outer = random.chance(0.5) ? 0.15 : 0;
  const auto outline = rounded_polygon(corners, {0, 0, outer, inner, 0, 0});
  const Point2 centre = {random.between(0, 0.5), thick / 2 - 1};
  return extrusion({outline, circle(centre, thick * random.between(0.2, 0.28), true)}, -0.4,
                   random.between(0.2, 0.5), edge, random);
}

Shape block(double edge, Random& random) {
  const double x = random.between(0.7, 1), y = random.between(0.6, 1);
  const auto outline = polygon({{-x, -y}, {x, -y}, {x, y}, {-x, y}});
  const Point2 centre = {random.between(-0.2, 0.2), random.between(-0.1, 0.1)};
  return extrusion({outline, circle(centre, random.between(0.25, 0.4), true)}, -random.between(0.3, 0.6), 0.4,
                   edge, random);
}

Shape cylinder(double edge, Random& random) {
  const double r = random.between(0.4, 0.9), z = random.between(0.5, 1);
  return revolution(lathe_profile({{0, -z}, {r, -z}, {r, z}, {0, z}}, {0, 0, 0, 0}), edge, random);
}

Shape cone(double edge, Random& random) {
  const double r = random.between(0.7, 0.9), z = random.between(0.4, 0.7);
  return revolution(lathe_profile({{0, -z}, {r, -z}, {0, z}}, {0, 0, 0}), edge, random);
}

Shape shaft(double edge, Random& random) {
  const int steps = random.whole(3, 4);
  std::vector<Point2> corners = {{0, -1}};
  std::vector<double> radii = {0};
  double radius = random.between(0.3, 0.45);
  for (int i = 0; i < steps; ++i) {
    const double low = -1 + 2.0 * i / steps, high = -1 + 2.0 * (i + 1) / steps;
    for (const double z : {low, high}) {
      corners.push_back({radius, z});
      radii.push_back(random.chance(0.5) ? random.between(0.05, 0.09) : 0);
    }
    radius += (i % 2 == 0 ? 1 : -1) * random.between(0.2, 0.3);
  }
  corners.push_back({0, 1});
  radii.push_back(0);
  return revolution(lathe_profile(corners, radii), edge, random);
}

Shape gear(double edge, Random& random) {
  const int teeth = random.whole(8, 12);
  const double root = random.between(0.7, 0.78), fillet = random.between(0.04, 0.06);
  const double tip = random.chance(0.5) ? 0.03 : 0;
  std::vector<Point2> corners;
  std::vector<double> radii;
  for (int i = 0; i < teeth; ++i) {
    for (const auto& [radius, at] : {std::pair{root, 0.0}, {1.0, 0.13}, {1.0, 0.42}, {root, 0.55}}) {
      const double angle = 2 * kPi * (i + at) / teeth;
      corners.push_back({radius * portable_cos(angle), radius * portable_sin(angle)});
      radii.push_back(radius < 1 ? fillet : tip);
    }
  }
  const auto hole = circle({0, 0}, random.between(0.25, 0.4), true);
  return extrusion({rounded_polygon(corners, radii), hole}, -random.between(0.15, 0.4), 0.2, edge, random);
}

Shape gem(double edge, Random& random) {
  double shortest = 0.15, smallest_cosine = 0.64;
  std::vector<HalfSpace> planes = random_planes(random);
  while (!is_well_cut(planes, shortest, smallest_cosine)) {
    shortest *= 0.99;
    planes = random_planes(random);
  }
  return convex_solid(planes, edge, random);
}

Shape twisted_star(double edge, Random& random) {
  const auto corners = star_corners(random);
  const double turn = random.between(0.5, 0.9), bend = random.between(0.1, 0.3);
  const std::vector<double> radii(corners.size(), random.chance(0.5) ? 0.08 : 0);
  Shape shape = extrusion({rounded_polygon(corners, radii)}, -0.9, 0.9, edge, random);
  for (Vec3d& p : shape.positions) {
    const double c = portable_cos(turn * p.z), s = portable_sin(turn * p.z), size = 0.6 + 0.15 * p.z;
    p = {size * (c * p.x - s * p.y) + bend * p.z * p.z, size * (s * p.x + c * p.y), p.z};
  }
  return shape;
}

}  // namespace burnish::testing
