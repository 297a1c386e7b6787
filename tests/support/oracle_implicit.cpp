#include "tests/support/oracle_implicit.h"

#include <cmath>

#include "tests/support/around.h"
#include "tests/support/oracle.h"

namespace burnish::testing {
namespace {

struct System {
  std::vector<double> mass;
  std::vector<std::map<Index, double>> weights;

  explicit System(std::size_t n) : mass(n), weights(n) {}
};

/// mass (x_v - old_v) + sum of weights (x_v - x_w) = 0 for inner vertices, by dense Gaussian elimination.
/// Diagonals dominate, so no rows need to change places.
Shape solved(const Shape& old, const Around& around, const System& system) {
  const std::size_t n = old.positions.size();
  std::vector<std::vector<double>> matrix(n, std::vector<double>(n));
  std::vector<Vec3d> x = old.positions;  // the right-hand side, then the solution
  for (Index v = 0; v < n; ++v) {
    matrix[v][v] = 1;
    if (around.boundary[v] || around.faces[v].empty()) continue;
    matrix[v][v] = system.mass[v];
    x[v] *= system.mass[v];
    for (const auto& [w, weight] : system.weights[v]) {
      matrix[v][v] += weight;
      matrix[v][w] -= weight;
    }
  }
  for (std::size_t pivot = 0; pivot < n; ++pivot) {
    for (std::size_t row = pivot + 1; row < n; ++row) {
      const double factor = matrix[row][pivot] / matrix[pivot][pivot];
      if (factor == 0) continue;
      for (std::size_t k = pivot; k < n; ++k) matrix[row][k] -= factor * matrix[pivot][k];
      x[row] -= x[pivot] * factor;
    }
  }
  for (std::size_t row = n; row-- > 0;) {
    for (std::size_t k = row + 1; k < n; ++k) x[row] -= x[k] * matrix[row][k];
    x[row] *= 1 / matrix[row][row];
  }
  return {x, old.triangles};
}

/// Fills and solves the system again for every iteration.
template <class Fill>
Shape repeated(Shape shape, int iterations, Fill&& fill) {
  const Around around(shape);
  const double h = oracle_mean_edge(shape);
  for (int i = 0; i < iterations; ++i) {
    System system(shape.positions.size());
    for (std::size_t f = 0; f < shape.triangles.size(); ++f) {
      for (const Index v : shape.triangles[f]) system.mass[v] += length(normal_times_area(shape, f)) / 3;
    }
    for (double& mass : system.mass) mass = std::max(mass, 1e-4 * h * h);
    fill(shape, around, h, system);
    shape = solved(shape, around, system);
  }
  return shape;
}

}  // namespace

Shape oracle_implicit_mean_curvature_flow(const Shape& shape, const ImplicitMeanCurvatureFlowParams& params,
                                          int iterations) {
  return repeated(shape, iterations, [&](const Shape& s, const Around&, double h, System& system) {
    for (const Triangle& t : s.triangles) {
      for (int c = 0; c < 3; ++c) {
        const Index a = t[(c + 1) % 3], b = t[(c + 2) % 3];
        const Vec3d p = s.positions[a] - s.positions[t[c]], q = s.positions[b] - s.positions[t[c]];
        const double cotangent = std::clamp(dot(p, q) / length(cross(p, q)), 0.0, params.largest_cotangent);
        system.weights[a][b] += params.time_step * h * h * cotangent / 2;
        system.weights[b][a] += params.time_step * h * h * cotangent / 2;
      }
    }
  });
}

Shape oracle_weighted_least_squares(const Shape& shape, const WeightedLeastSquaresParams& params,
                                    int iterations) {
  return repeated(shape, iterations, [&](const Shape& s, const Around& around, double h, System& system) {
    std::vector<Vec3d> normals(s.positions.size());
    for (Index v = 0; v < normals.size(); ++v) {
      for (const std::size_t f : around.faces[v]) normals[v] += normal_times_area(s, f);
      normals[v] *= 1 / length(normals[v]);
    }
    for (Index v = 0; v < normals.size(); ++v) {
      for (const Index w : around.neighbours[v]) {
        const double x = length(normals[v] - normals[w]) / params.sigma;
        system.weights[v][w] = params.lambda * h * h * std::exp(-x * x);
      }
    }
  });
}

}  // namespace burnish::testing
