#include "tests/support/irregular.h"

#include <algorithm>
#include <map>
#include <set>

namespace burnish::testing {
namespace {

constexpr double kLeastAngle = 15;  // degrees

Vec3d unit_normal(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d n = cross(b - a, c - a);
  return n * (1 / std::max(length(n), 1e-300));
}

/// Where the lines between cells lie: steps differ by a factor of about two along the way.
std::vector<double> uneven_steps(int cells, bool wraps, Random& random) {
  const double phase = random.between(0, 2 * kPi);
  std::vector<double> at(static_cast<std::size_t>(cells) + 1);
  for (int i = 0; i <= cells; ++i) {
    const double x = static_cast<double>(i) / cells, waves = wraps ? 2 : 1.5;
    const auto bent = [&](double t) {
      return t + 0.3 / (2 * kPi * waves) * portable_sin(2 * kPi * waves * t + phase);
    };
    at[static_cast<std::size_t>(i)] = (bent(x) - bent(0)) / (bent(1) - bent(0));
  }
  return at;
}

}  // namespace

Vec3d Random::direction() {
  for (;;) {
    const Vec3d p = {between(-1, 1), between(-1, 1), between(-1, 1)};
    if (const double size = length(p); size > 0.1 && size < 1) return p * (1 / size);
  }
}

std::array<double, 2> Random::in_disc() {
  for (;;) {
    const double x = between(-1, 1), y = between(-1, 1);
    if (x * x + y * y < 1) return {x, y};
  }
}

double smallest_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  double smallest = kPi;
  for (const auto& [p, q, r] : {std::array{a, b, c}, {b, c, a}, {c, a, b}}) {
    const double along = dot(q - p, r - p), across = length(cross(q - p, r - p));
    smallest = std::min(smallest, portable_angle(across, along));
  }
  return smallest * kDegreesPerRadian;
}

void add_quad(Shape& shape, Index a, Index b, Index c, Index d, Random& random) {
  const auto& p = shape.positions;
  // Twisted quads have diagonals along which both triangles turn over: normals tell.
  const auto worth = [&](const Triangle& s, const Triangle& t) {
    const double turn = dot(unit_normal(p[s[0]], p[s[1]], p[s[2]]), unit_normal(p[t[0]], p[t[1]], p[t[2]]));
    if (turn < 0) return turn;
    return std::min(smallest_angle(p[s[0]], p[s[1]], p[s[2]]), smallest_angle(p[t[0]], p[t[1]], p[t[2]]));
  };
  const Triangle one[] = {{a, b, c}, {a, c, d}}, two[] = {{a, b, d}, {b, c, d}};
  const double worth_one = worth(one[0], one[1]), worth_two = worth(two[0], two[1]);
  bool first = random.chance(0.5);
  if (std::min(worth_one, worth_two) < kLeastAngle) first = worth_one > worth_two;
  for (const Triangle& t : first ? one : two) shape.triangles.push_back(t);
}

void flip_edges(Shape& shape, double share, Random& random) {
  std::map<std::array<Index, 2>, Index> triangle_of;  // directed edge -> its triangle
  for (Index t = 0; t < shape.triangles.size(); ++t) {
    const auto& [a, b, c] = shape.triangles[t];
    triangle_of[{a, b}] = triangle_of[{b, c}] = triangle_of[{c, a}] = t;
  }
  std::set<std::array<Index, 2>> added;
  std::vector<std::uint8_t> flipped(shape.triangles.size());
  const auto& p = shape.positions;
  const auto apex = [&](Index t, Index a, Index b) {
    const auto& corners = shape.triangles[t];
    return *std::ranges::find_if(corners, [&](Index v) { return v != a && v != b; });
  };
  for (const auto& [edge, left] : triangle_of) {
    const auto [a, b] = edge;
    const auto twin = triangle_of.find({b, a});
    if (a > b || twin == triangle_of.end() || !random.chance(share)) continue;
    const Index right = twin->second;
    if (flipped[left] != 0 || flipped[right] != 0) continue;
    const Index c = apex(left, a, b), d = apex(right, a, b);
    const std::array<Index, 2> cross_edge = {std::min(c, d), std::max(c, d)};
    if (triangle_of.contains({c, d}) || triangle_of.contains({d, c}) || added.contains(cross_edge)) continue;
    const Vec3d old_normal = unit_normal(p[a], p[b], p[c]);
    bool flat = true;
    for (const Vec3d& n :
         {unit_normal(p[b], p[a], p[d]), unit_normal(p[a], p[d], p[c]), unit_normal(p[d], p[b], p[c])}) {
      flat = flat && dot(n, old_normal) > 0.95;
    }
    if (!flat || smallest_angle(p[a], p[d], p[c]) < kLeastAngle ||
        smallest_angle(p[d], p[b], p[c]) < kLeastAngle)
      continue;
    shape.triangles[left] = {a, d, c};
    shape.triangles[right] = {d, b, c};
    flipped[left] = flipped[right] = 1;
    added.insert(cross_edge);
  }
}

Shape parametric(int nu, int nv, Wraps wraps, const std::function<Vec3d(double, double)>& place,
                 Random& random) {
  const int rows = nu + (wraps.u ? 0 : 1), columns = nv + (wraps.v ? 0 : 1);
  const auto at_u = uneven_steps(nu, wraps.u, random), at_v = uneven_steps(nv, wraps.v, random);
  Shape shape;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      auto [du, dv] = random.in_disc();
      if (!wraps.u && (i == 0 || i == nu)) du = 0;  // the rim stays where it is
      if (!wraps.v && (j == 0 || j == nv)) dv = 0;
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double step_u = at_u[std::min(i + 1, nu)] - at_u[std::min(i, nu - 1)];
      const double step_v = at_v[std::min(j + 1, nv)] - at_v[std::min(j, nv - 1)];
      shape.positions.push_back(place(at_u[a] + du / 3 * step_u, at_v[b] + dv / 3 * step_v));
    }
  }
  const auto vertex = [&](int i, int j) { return static_cast<Index>(i % rows * columns + j % columns); };
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      add_quad(shape, vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1), random);
    }
  }
  return shape;
}

}  // namespace burnish::testing
