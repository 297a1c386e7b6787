#include <algorithm>
#include <cmath>

#include "tests/support/facets.h"
#include "tests/support/procedural_kinds.h"

namespace burnish::testing {
namespace {

/// Hills and dents of one width at random places.
struct Bump {
  Vec3d at;
  double height, width;
};

std::vector<Bump> random_bumps(int count, double height, double width, Random& random) {
  std::vector<Bump> bumps;
  for (int i = 0; i < count; ++i) {
    bumps.push_back({random.direction(), height * random.between(-0.6, 1), width * random.between(0.7, 1.4)});
  }
  return bumps;
}

double height_at(const std::vector<Bump>& bumps, const Vec3d& p) {
  double height = 0;
  for (const Bump& bump : bumps) {
    const Vec3d way = p - bump.at;
    height += bump.height * portable_exp(-dot(way, way) / (2 * bump.width * bump.width));
  }
  return height;
}

/// A sphere of quads with bumps, moved vertices and random diagonals.
Shape bumpy_sphere(const std::vector<Bump>& bumps, double edge, Random& random) {
  const int n = std::max(4, static_cast<int>(std::lround(kPi / 2 / edge)));
  const Shape even = cube(n);
  Shape shape;
  for (const Vec3d& at : even.positions) {
    Vec3d p;
    for (std::size_t axis = 0; axis < 3; ++axis) {  // equal angles, so that the squares are of like size
      p[axis] = portable_sin(at[axis] * kPi / 4) / portable_cos(at[axis] * kPi / 4);
    }
    p *= 1 / length(p);
    const Vec3d aside = random.direction() * (0.33 * kPi / 2 / n);
    p += aside - p * dot(aside, p);
    p *= 1 / length(p);
    shape.positions.push_back(p * (0.75 * (1 + height_at(bumps, p))));
  }
  for (std::size_t t = 0; t < even.triangles.size(); t += 2) {
    const auto& [a, b, c] = even.triangles[t];
    const auto& [e, f, g] = even.triangles[t + 1];
    if (c == f) {
      add_quad(shape, a, b, c, g, random);
    } else {
      add_quad(shape, e, f, g, c, random);
    }
  }
  return shape;
}

Vec3d unit(const Vec3d& a) { return a * (1 / length(a)); }

/// A curve that winds p times around the axis and q times through the ring.
struct TorusCurve {
  int p, q;
  double wide;  // radius of the ring's body, whose centre line has radius 0.6

  Vec3d at(double t) const {
    const double r = 0.6 + wide * portable_cos(q * t);
    return {r * portable_cos(p * t), r * portable_sin(p * t), wide * portable_sin(q * t)};
  }
  Vec3d outwards(double t) const {
    return {portable_cos(q * t) * portable_cos(p * t), portable_cos(q * t) * portable_sin(p * t),
            portable_sin(q * t)};
  }
};

int cells(double length, double edge) { return std::max(6, static_cast<int>(std::lround(length / edge))); }

/// The graph of a height over the square from -1 to 1.
Shape graph(const std::function<double(double x, double y)>& height, double edge, Random& random) {
  const int n = cells(2, edge);
  const auto place = [&](double u, double v) {
    const double x = 2 * u - 1, y = 2 * v - 1;
    return Vec3d{x, y, height(x, y)};
  };
  return parametric(n, n, {}, place, random);
}

/// 1 - |x| with its top rounded: a crease of this width.
double crease(double x, double width) { return 1 - std::sqrt(x * x + width * width); }

}  // namespace

Shape coarse_bumps(double edge, Random& random) {
  const auto bumps = random_bumps(14, 0.35, 0.4, random);
  return bumpy_sphere(bumps, edge, random);
}

Shape fine_bumps(double edge, Random& random) {
  auto bumps = random_bumps(60, 0.08, 0.13, random);
  for (const auto& [count, height, width] : {std::tuple{6, 0.2, 0.5}, {120, 0.03, 0.06}}) {
    for (const Bump& bump : random_bumps(count, height, width, random)) bumps.push_back(bump);
  }
  return bumpy_sphere(bumps, edge, random);
}

Shape knot(double edge, Random& random) {
  const bool trefoil = random.chance(0.5);
  const TorusCurve curve = {2, trefoil ? 3 : 5, random.between(0.24, 0.28)};
  const double radius = trefoil ? 0.13 : 0.1, waves = random.whole(5, 12), swell = random.between(0, 0.25);
  double way = 0;
  for (int i = 0; i < 1000; ++i)
    way += length(curve.at(2 * kPi * (i + 1) / 1000) - curve.at(2 * kPi * i / 1000));
  const auto place = [&](double u, double v) {
    const double t = 2 * kPi * u;
    const Vec3d along = unit(curve.at(t + 1e-4) - curve.at(t - 1e-4));
    const Vec3d out = unit(curve.outwards(t) - along * dot(curve.outwards(t), along)),
                aside = cross(out, along);
    const double r = radius * (1 + swell * portable_cos(waves * t));
    return curve.at(t) + (out * portable_cos(2 * kPi * v) + aside * portable_sin(2 * kPi * v)) * r;
  };
  return parametric(cells(way, edge), cells(2 * kPi * radius, edge), {true, true}, place, random);
}

Shape blobs(double edge, Random& random) {
  std::vector<Bump> balls;
  for (int i = 0; i < 9; ++i) {
    balls.push_back({random.direction() * random.between(0.2, 0.55), 1, random.between(0.16, 0.21)});
  }
  return implicit_surface([&](const Vec3d& p) { return height_at(balls, p) - 0.3; }, edge, random);
}

Shape ridges(double edge, Random& random) {
  struct Ridge {
    double x, y, offset, height, width;
  };
  std::vector<Ridge> all;
  for (int i = 0; i < 6; ++i) {
    const double angle = random.between(0, kPi);
    all.push_back({portable_cos(angle), portable_sin(angle), random.between(-0.7, 0.7),
                   random.between(0.1, 0.3), random.between(0.01, 0.1)});
  }
  const auto hills = random_bumps(10, 0.3, 0.25, random);
  return graph(
      [&](double x, double y) {
        double z = height_at(hills, {x, y, 0});
        for (const Ridge& r : all) z += r.height * crease(x * r.x + y * r.y - r.offset, r.width);
        return z;
      },
      edge, random);
}

Shape cloth(double edge, Random& random) {
  const double folds = random.between(2, 4), drift = random.between(0.5, 1.5),
               depth = random.between(0.1, 0.16);
  const double turn = random.between(0, 2 * kPi);
  return graph(
      [&](double x, double y) {
        const double phase = kPi * folds * x + drift * portable_sin(2 * y + turn) + turn;
        const double fold = portable_sin(phase) + 0.3 * portable_sin(2 * phase + y);  // steeper on one side
        return depth * (1 + 0.5 * y) * fold + 0.15 * portable_cos(1.5 * y + x);
      },
      edge, random);
}

Shape hair(double edge, Random& random) {
  const double strands = random.between(6, 9), wave = random.between(0.2, 0.5),
               turn = random.between(0, 2 * kPi);
  return graph(
      [&](double x, double y) {
        const double across = x + wave * 0.3 * portable_sin(3 * y + turn) + 0.1 * portable_sin(7 * y);
        const double groove = std::sqrt(0.02 + portable_sin(kPi * strands * across / 2) *
                                                   portable_sin(kPi * strands * across / 2));
        return 0.1 * groove + 0.3 * portable_cos(1.2 * x) * portable_cos(0.8 * y);
      },
      edge, random);
}

Shape relief(double edge, Random& random) {
  const double a = random.between(0.8, 1), b = random.between(0.6, 1);
  auto hills = random_bumps(16, 0.6, 0.17, random);
  for (Bump& hill : hills) hill.at.z = 0;
  const auto height = [&](const Point2& p) {
    const double u = p.x / a, v = p.y / b;
    return 1.2 * (1 - u * u) * (1 - v * v) * (0.3 + height_at(hills, {p.x, p.y, 0}));
  };
  const auto outline = polygon({{-a, -b}, {a, -b}, {a, b}, {-a, b}});
  return extrusion({outline}, -0.7, 0, edge, random, height);
}

Shape vase(double edge, Random& random) {
  const double waves = random.between(1.5, 3.5), swing = random.between(0.12, 0.2),
               turn = random.between(0, 2 * kPi);
  const auto radius = [=](double t) { return 0.55 + swing * portable_cos(kPi * waves * t + turn); };
  const auto wall = [=](double t) { return Point2{radius(t), 2 * t - 1}; };
  double way = 0;
  for (int i = 0; i < 1000; ++i) {
    const Point2 from = wall(i / 1000.0), to = wall((i + 1) / 1000.0);
    way += std::hypot(to.x - from.x, to.y - from.y);
  }
  const Point2 foot = wall(0), rim = wall(1);
  return revolution({line({0, -1}, foot), {wall, way, 8}, line(rim, {0, 1})}, edge, random);
}

}  // namespace burnish::testing
