#include "tests/support/oracle_vertex.h"

#include <cmath>
#include <numbers>

#include "tests/support/around.h"
#include "tests/support/oracle.h"

namespace burnish::testing {
namespace {

using Vectors = std::vector<Vec3d>;

/// Mean of the neighbours' values.
Vec3d mean_around(const Vectors& values, const Around& around, Index v) {
  Vec3d sum;
  for (const Index w : around.neighbours[v]) sum += values[w];
  return sum * (1.0 / static_cast<double>(around.neighbours[v].size()));
}

/// U, 0 on the boundary.
Vectors umbrellas(const Vectors& values, const Around& around) {
  Vectors result(values.size());
  for (Index v = 0; v < values.size(); ++v) {
    if (!around.boundary[v]) result[v] = mean_around(values, around, v) - values[v];
  }
  return result;
}

double sinc_window(WindowedSincParams::Window window, int n, int degree) {
  const double a = n * std::numbers::pi / (degree + 1);
  switch (window) {
    case WindowedSincParams::Window::Blackman:
      return 0.42 + 0.5 * std::cos(a) + 0.08 * std::cos(2 * a);
    case WindowedSincParams::Window::Hanning:
      return 0.5 + 0.5 * std::cos(a);
    case WindowedSincParams::Window::Rectangle:
      return 1;
    case WindowedSincParams::Window::Hamming:
      break;
  }
  return 0.54 + 0.46 * std::cos(a);
}

std::vector<double> sinc_terms(const WindowedSincParams& params, int degree, double phi) {
  std::vector<double> terms;
  for (int n = 0; n <= degree; ++n) {
    const double sinc = n == 0 ? phi : 2 * std::sin(n * phi) / n;
    terms.push_back(sinc_window(params.window, n, degree) * sinc / std::numbers::pi);
  }
  return terms;
}

double chebyshev_sum(const std::vector<double>& terms, double x) {
  double sum = 0;
  for (std::size_t n = 0; n < terms.size(); ++n)
    sum += terms[n] * std::cos(static_cast<double>(n) * std::acos(x));
  return sum;
}

/// The coefficients c_n: the least phi that makes the pass band pass, found in tiny steps and then by
/// halving.
std::vector<double> sinc_coefficients(const WindowedSincParams& params, int degree) {
  const double x = 1 - params.pass_band / 2, step = std::numbers::pi / (100.0 * (degree + 1));
  const auto passes = [&](double phi) { return chebyshev_sum(sinc_terms(params, degree, phi), x) >= 1; };
  double high = std::acos(x);
  while (high < std::numbers::pi && !passes(high)) high += step;
  for (double low = high - step; high < std::numbers::pi && high - low > 1e-14;) {
    const double middle = (low + high) / 2;
    (passes(middle) ? high : low) = middle;
  }
  std::vector<double> terms = sinc_terms(params, degree, std::min(high, std::numbers::pi));
  const double at_zero = chebyshev_sum(terms, 1);
  for (double& c : terms) c /= at_zero;
  return terms;
}

/// All that paths of vertices nearer than the radius lead to.
std::set<Index> ball(const Shape& shape, const Around& around, Index v, double radius) {
  std::set<Index> found{v};
  for (bool grown = true; grown;) {
    grown = false;
    for (const Index at : std::set<Index>(found)) {
      for (const Index w : around.neighbours[at]) {
        if (length(shape.positions[w] - shape.positions[v]) < radius) grown |= found.insert(w).second;
      }
    }
  }
  found.erase(v);
  return found;
}

}  // namespace

Shape oracle_bilaplacian(const Shape& shape, double lambda, int iterations) {
  const Around around(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Vectors twice = umbrellas(umbrellas(result.positions, around), around);
    result = jacobi(result, around, 1,
                    [&](const Shape& s, Index v) { return s.positions[v] - twice[v] * lambda; });
  }
  return result;
}

Shape oracle_hc_laplacian(const Shape& shape, const HcLaplacianParams& params, int iterations) {
  const Around around(shape);
  Shape p = shape;
  for (int i = 0; i < iterations; ++i) {
    const Shape q =
        jacobi(p, around, 1, [&](const Shape& s, Index v) { return mean_around(s.positions, around, v); });
    Vectors b;
    for (Index v = 0; v < p.positions.size(); ++v) {
      b.push_back(q.positions[v] - (shape.positions[v] * params.alpha + p.positions[v] * (1 - params.alpha)));
    }
    p = jacobi(q, around, 1, [&](const Shape& s, Index v) {
      return s.positions[v] - (b[v] * params.beta + mean_around(b, around, v) * (1 - params.beta));
    });
  }
  return p;
}

Shape oracle_windowed_sinc(const Shape& shape, const WindowedSincParams& params, int degree) {
  const Around around(shape);
  const std::vector<double> c = sinc_coefficients(params, degree);
  const auto times_x = [&](const Vectors& values) {  // x = 1 - k/2 = 1 + U/2
    Vectors result = umbrellas(values, around);
    for (std::size_t v = 0; v < result.size(); ++v) result[v] = values[v] + result[v] * 0.5;
    return result;
  };
  Shape result = shape;
  for (Vec3d& p : result.positions) p *= c[0];
  Vectors last = shape.positions, now = times_x(last);
  for (int n = 1; n <= degree; ++n) {
    for (std::size_t v = 0; v < now.size(); ++v)
      result.positions[v] += now[v] * c[static_cast<std::size_t>(n)];
    Vectors next = times_x(now);
    for (std::size_t v = 0; v < next.size(); ++v) next[v] = next[v] * 2.0 - last[v];
    last = std::move(now);
    now = std::move(next);
  }
  return result;
}

double oracle_sinc_transfer(const WindowedSincParams& params, int degree, double k) {
  return chebyshev_sum(sinc_coefficients(params, degree), 1 - k / 2);
}

Shape oracle_bilateral(const Shape& shape, const BilateralParams& params, int iterations) {
  const Around around(shape);
  const double h = oracle_mean_edge(shape), closeness = params.sigma_c * h;
  return jacobi(shape, around, iterations, [&](const Shape& s, Index v) {
    Vec3d n;
    for (const std::size_t f : around.faces[v]) n += normal_times_area(s, f);
    n *= 1 / length(n);
    std::set<Index> near = around.neighbours[v];
    if (params.neighbourhood == BilateralParams::Neighbourhood::Ball)
      near = ball(s, around, v, 2 * closeness);
    if (near.empty()) return s.positions[v];

    std::vector<double> distances, heights;
    double mean = 0, mean_square = 0, variance = 0;
    for (const Index q : near) {
      distances.push_back(length(s.positions[q] - s.positions[v]));
      heights.push_back(dot(n, s.positions[q] - s.positions[v]));
      mean += heights.back() / static_cast<double>(near.size());
      mean_square += heights.back() * heights.back() / static_cast<double>(near.size());
    }
    for (const double height : heights)
      variance += (height - mean) * (height - mean) / static_cast<double>(near.size());
    variance = std::max(variance, 0.09 * mean_square);
    if (params.sigma_s > 0) variance = params.sigma_s * h * params.sigma_s * h;

    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const double weight = std::exp(-distances[i] * distances[i] / (2 * closeness * closeness)) *
                            std::exp(-heights[i] * heights[i] / (2 * variance));
      sum += weight * heights[i];
      weights += weight;
    }
    return weights > 0 ? s.positions[v] + n * (sum / weights) : s.positions[v];
  });
}

}  // namespace burnish::testing
