#include <cmath>

#include "tests/support/irregular.h"

namespace burnish::testing {
namespace {

using Field = std::function<double(const Vec3d&)>;

Vec3d gradient(const Field& field, const Vec3d& p) {
  constexpr double kStep = 1e-4;
  Vec3d g;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d low = p, high = p;
    low[axis] -= kStep, high[axis] += kStep;
    g[axis] = (field(high) - field(low)) / (2 * kStep);
  }
  return g;
}

/// A few steps of Newton's method along the gradient.
Vec3d on_surface(const Field& field, Vec3d p, double most) {
  for (int step = 0; step < 5; ++step) {
    const Vec3d g = gradient(field, p);
    const Vec3d way = g * (-field(p) / std::max(dot(g, g), 1e-12));
    p += way * std::min(1.0, most / std::max(length(way), 1e-12));
  }
  return p;
}

/// Samples at the corners of n^3 cells of the cube from -1 to 1.
class Samples {
 public:
  Samples(const Field& field, int n) : n_(n), values_(static_cast<std::size_t>(n + 1) * (n + 1) * (n + 1)) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        for (int k = 0; k <= n; ++k) values_[index({i, j, k})] = field(place({i, j, k}));
      }
    }
  }

  Vec3d place(const std::array<int, 3>& c) const {
    const auto along = [&](int i) { return 2.0 * i / n_ - 1; };
    return {along(c[0]), along(c[1]), along(c[2])};
  }
  double value(const std::array<int, 3>& c) const { return values_[index(c)]; }
  std::size_t index(const std::array<int, 3>& c) const {
    return (static_cast<std::size_t>(c[0]) * (n_ + 1) + c[1]) * (n_ + 1) + c[2];
  }

 private:
  int n_;
  std::vector<double> values_;
};

/// The mean of the places where the surface crosses the edges of a cell; false when it does not.
bool mean_crossing(const Samples& samples, const std::array<int, 3>& cell, Vec3d& mean) {
  Vec3d sum;
  int crossings = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1U) != 0) continue;
      std::array<int, 3> a = cell;
      for (unsigned k = 0; k < 3; ++k) a[k] += static_cast<int>(corner >> k & 1U);
      std::array<int, 3> b = a;
      ++b[axis];
      const double low = samples.value(a), high = samples.value(b);
      if ((low > 0) == (high > 0)) continue;
      sum += samples.place(a) + (samples.place(b) - samples.place(a)) * (low / (low - high));
      ++crossings;
    }
  }
  if (crossings > 0) mean = sum * (1.0 / crossings);
  return crossings > 0;
}

using Quad = std::array<Index, 4>;

/// Moves every vertex to the mean of its neighbours, three times: crossings near a corner of a cell lie close
/// together.
void spread(std::vector<Vec3d>& positions, const std::vector<Quad>& quads) {
  for (int step = 0; step < 3; ++step) {
    std::vector<Vec3d> sums(positions.size());
    std::vector<double> counts(positions.size());
    for (const Quad& q : quads) {
      for (std::size_t i = 0; i < 4; ++i) {
        sums[q[i]] += positions[q[(i + 1) % 4]] + positions[q[(i + 3) % 4]];
        counts[q[i]] += 2;
      }
    }
    for (std::size_t v = 0; v < sums.size(); ++v) positions[v] = sums[v] * (1 / counts[v]);
  }
}

}  // namespace

Shape implicit_surface(const Field& field, double edge, Random& random) {
  const int n = static_cast<int>(std::lround(2 / edge));
  const double side = 2.0 / n;
  const Samples samples(field, n);
  Shape shape;
  std::vector<Quad> quads;
  std::vector<Index> vertex_of(static_cast<std::size_t>(n + 1) * (n + 1) * (n + 1), kNone);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        Vec3d p;
        if (!mean_crossing(samples, {i, j, k}, p)) continue;
        vertex_of[samples.index({i, j, k})] = static_cast<Index>(shape.positions.size());
        shape.positions.push_back(p);
      }
    }
  }
  // Around every edge that the surface crosses, the four cells that share it.
  for (int i = 1; i < n; ++i) {
    for (int j = 1; j < n; ++j) {
      for (int k = 1; k < n; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::array<int, 3> low = {i, j, k};
          std::array<int, 3> high = low;
          ++high[axis];
          if ((samples.value(low) > 0) == (samples.value(high) > 0)) continue;
          const auto cell = [&](int u, int v) {
            std::array<int, 3> c = low;
            c[(axis + 1) % 3] -= u;
            c[(axis + 2) % 3] -= v;
            return vertex_of[samples.index(c)];
          };
          const Index a = cell(1, 1), b = cell(0, 1), c = cell(0, 0), d = cell(1, 0);
          quads.push_back(samples.value(low) > 0 ? Quad{a, b, c, d} : Quad{d, c, b, a});
        }
      }
    }
  }
  spread(shape.positions, quads);
  for (Vec3d& p : shape.positions) {
    p = on_surface(field, p + random.direction() * random.between(0, 0.25 * side), side);
  }
  for (const auto& [a, b, c, d] : quads) add_quad(shape, a, b, c, d, random);
  return shape;
}

}  // namespace burnish::testing
