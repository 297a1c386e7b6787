#include "tests/support/oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/around.h"

namespace burnish::testing {
namespace {

/// Eq. 3 with weights 1 or 1/length.
Vec3d umbrella(const Shape& shape, const Around& around, Index v, bool inverse_length) {
  Vec3d sum;
  double weights = 0;
  for (const Index w : around.neighbours[v]) {
    const Vec3d way = shape.positions[w] - shape.positions[v];
    const double weight = inverse_length ? 1 / length(way) : 1;
    sum += way * weight;
    weights += weight;
  }
  return sum * (1 / weights);
}

/// N(R) of Eq. 1.
std::set<std::size_t> neighbourhood(const Shape& shape, const Around& around, std::size_t f,
                                    AdaptiveParams::Neighbourhood kind) {
  std::set<std::size_t> result;
  const Triangle& t = shape.triangles[f];
  for (int e = 0; e < 3; ++e) {
    if (kind == AdaptiveParams::Neighbourhood::Edges) {
      const auto& at = around.edge_faces.at(std::minmax(t[e], t[(e + 1) % 3]));
      result.insert(at.begin(), at.end());
    } else {
      result.insert(around.faces[t[e]].begin(), around.faces[t[e]].end());
    }
  }
  result.erase(f);
  return result;
}

std::vector<Vec3d> expected_normals(const Shape& shape, const Around& around, const AdaptiveParams& params) {
  std::vector<Vec3d> expected;
  for (std::size_t f = 0; f < shape.triangles.size(); ++f) {
    Vec3d sum;
    double areas = 0;
    for (const std::size_t s : neighbourhood(shape, around, f, params.neighbourhood)) {
      sum += normal_times_area(shape, s);
      areas += length(normal_times_area(shape, s));
    }
    if (length(sum) <= 1e-6 * areas) {
      sum = normal_times_area(shape, f);
      areas = length(sum);
    }
    expected.push_back(sum * (1 / (params.normals == AdaptiveParams::Normals::Unit ? length(sum) : areas)));
  }
  return expected;
}

double g(const AdaptiveParams& params, double x) {
  switch (params.coefficient) {
    case AdaptiveParams::Coefficient::Linear:
      return std::min(1.0, x);
    case AdaptiveParams::Coefficient::Gaussian:
      return 1 - std::exp(-x / (params.sigma * params.sigma));
    case AdaptiveParams::Coefficient::Exponential:
      break;
  }
  return std::min(1.5, std::exp(x));
}

double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const double t = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
  return length(p - (a + (b - a) * t));
}

double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d n = cross(b - a, c - a) * (1 / length(cross(b - a, c - a)));
  const Vec3d q = p - n * dot(p - a, n);  // the foot of the perpendicular
  const bool inside = dot(cross(b - a, q - a), n) >= 0 && dot(cross(c - b, q - b), n) >= 0 &&
                      dot(cross(a - c, q - c), n) >= 0;
  if (inside) return length(p - q);
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

}  // namespace

Shape oracle_laplacian(const Shape& shape, double lambda, int iterations) {
  const Around around(shape);
  return jacobi(shape, around, iterations, [&](const Shape& s, Index v) {
    return s.positions[v] + umbrella(s, around, v, false) * lambda;
  });
}

Shape oracle_taubin(const Shape& shape, double lambda, double mu, int iterations) {
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) result = oracle_laplacian(oracle_laplacian(result, lambda, 1), mu, 1);
  return result;
}

Shape oracle_mean_curvature_flow(const Shape& shape, const MeanCurvatureFlowParams& params, int iterations) {
  const Around around(shape);
  const double h = oracle_mean_edge(shape), dt = params.time_step * h * h;
  return jacobi(shape, around, iterations, [&](const Shape& s, Index v) {
    Vec3d pull;
    double weights = 0, mass = 0;
    for (const Index w : around.neighbours[v]) {
      double weight = 0;
      for (const std::size_t f : around.edge_faces.at(std::minmax(v, w))) {
        for (const Index opposite : s.triangles[f]) {
          if (opposite == v || opposite == w) continue;
          const Vec3d a = s.positions[v] - s.positions[opposite], b = s.positions[w] - s.positions[opposite];
          weight += std::clamp(dot(a, b) / length(cross(a, b)), 0.0, params.largest_cotangent) / 2;
        }
      }
      pull += (s.positions[w] - s.positions[v]) * weight;
      weights += weight;
    }
    for (const std::size_t f : around.faces[v]) mass += length(normal_times_area(s, f)) / 3;
    if (weights == 0) return s.positions[v];
    return s.positions[v] + pull * (std::min(1.0, dt * weights / mass) / weights);
  });
}

double oracle_mean_edge(const Shape& shape) {
  const Around around(shape);
  double sum = 0;
  for (const auto& [edge, faces] : around.edge_faces) {
    sum += length(shape.positions[edge.first] - shape.positions[edge.second]);
  }
  return sum / static_cast<double>(around.edge_faces.size());
}

Shape oracle_adaptive(const Shape& shape, const AdaptiveParams& params, int iterations) {
  const Around around(shape);
  const double scale = params.scale > 0 ? params.scale : oracle_mean_edge(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const auto expected = expected_normals(result, around, params);
    result = jacobi(result, around, 1, [&](const Shape& s, Index v) {
      Vec3d offset;
      double weights = 0;
      for (const std::size_t f : around.faces[v]) {
        const double weight =
            params.offsets == AdaptiveParams::Offsets::Area ? length(normal_times_area(s, f)) : 1;
        offset += expected[f] * (weight * dot(centroid(s, f) - s.positions[v], expected[f]));
        weights += weight;
      }
      const Vec3d u = umbrella(s, around, v, params.umbrella == AdaptiveParams::Umbrella::InverseLength);
      return s.positions[v] + offset * (g(params, dot(u, u) / (scale * scale)) / weights);
    });
  }
  return result;
}

double oracle_ev(const Shape& result, const Shape& reference) {
  const Around around(result);
  double weighted = 0, area = 0;
  for (std::size_t f = 0; f < result.triangles.size(); ++f) area += length(normal_times_area(result, f));
  for (std::size_t v = 0; v < result.positions.size(); ++v) {
    double nearest = std::numeric_limits<double>::infinity(), at_vertex = 0;
    for (const Triangle& t : reference.triangles) {
      nearest = std::min(nearest, distance_to_triangle(result.positions[v], reference.positions[t[0]],
                                                       reference.positions[t[1]], reference.positions[t[2]]));
    }
    for (const std::size_t f : around.faces[v]) at_vertex += length(normal_times_area(result, f));
    weighted += at_vertex * nearest * nearest;
  }
  return std::sqrt(weighted / (3 * area));
}

}  // namespace burnish::testing
