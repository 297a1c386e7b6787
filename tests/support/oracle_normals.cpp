#include "tests/support/oracle_normals.h"

#include <algorithm>
#include <cmath>

#include "tests/support/around.h"
#include "tests/support/oracle.h"

namespace burnish::testing {
namespace {

using Normals = std::vector<Vec3d>;
using Matrix = std::vector<std::vector<double>>;

Vec3d unit(const Vec3d& a) { return a * (1 / length(a)); }
double area(const Shape& s, std::size_t f) { return length(normal_times_area(s, f)); }

Normals normals_of(const Shape& s) {
  Normals normals;
  for (std::size_t f = 0; f < s.triangles.size(); ++f) normals.push_back(unit(normal_times_area(s, f)));
  return normals;
}

std::set<std::size_t> near(const Shape& s, const Around& around, std::size_t f, FaceNeighbourhood kind) {
  std::set<std::size_t> result;
  const Triangle& t = s.triangles[f];
  for (int e = 0; e < 3; ++e) {
    const auto& at = kind == FaceNeighbourhood::Edges
                         ? around.edge_faces.at(std::minmax(t[e], t[(e + 1) % 3]))
                         : around.faces[t[e]];
    result.insert(at.begin(), at.end());
  }
  result.erase(f);
  return result;
}

/// unit(sum of weight(j, i) n(j)) over the neighbours j of each i.
template <class Weight>
Normals averaged(const Shape& s, const Around& around, FaceNeighbourhood kind, const Normals& n,
                 Weight&& weight) {
  Normals result;
  for (std::size_t i = 0; i < n.size(); ++i) {
    Vec3d sum;
    double weights = 0;
    for (const std::size_t j : near(s, around, i, kind)) {
      sum += n[j] * weight(j, i);
      weights += weight(j, i);
    }
    result.push_back(length(sum) > 1e-6 * weights ? unit(sum) : n[i]);
  }
  return result;
}

Vec3d offset(const Shape& s, const Around& around, const Normals& n, Index v, bool by_area) {
  Vec3d sum;
  double weights = 0;
  for (const std::size_t f : around.faces[v]) {
    const double weight = by_area ? area(s, f) : 1;
    sum += n[f] * (weight * dot(centroid(s, f) - s.positions[v], n[f]));
    weights += weight;
  }
  return sum * (1 / weights);
}

/// `areas` is the shape whose areas weigh the normals.
Vec3d tangential(const Shape& s, const Around& around, const Normals& n, const Shape& areas, Index v) {
  Vec3d way, sum;
  for (const Index w : around.neighbours[v]) way += s.positions[w] - s.positions[v];
  way *= 1.0 / static_cast<double>(around.neighbours[v].size());
  for (const std::size_t f : around.faces[v]) sum += n[f] * area(areas, f);
  return way - unit(sum) * dot(way, unit(sum));
}

/// exp(-|c(i) - c(j)|^2 / (2 sigma_c^2) - |g(i) - g(j)|^2 / (2 sigma_s^2)).
class Bilateral {
 public:
  Bilateral(const Shape& s, const Around& around, const Normals& guide, double sigma_c, double sigma_s)
      : s_(s), guide_(guide), sigma_s_(sigma_s) {
    double sum = 0, pairs = 0;
    for (const auto& [edge, at] : around.edge_faces) {
      if (at.size() != 2) continue;
      sum += length(centroid(s, at[0]) - centroid(s, at[1]));
      ++pairs;
    }
    sigma_c_ = sigma_c * sum / pairs;
  }

  double operator()(std::size_t j, std::size_t i) const {
    const Vec3d way = centroid(s_, i) - centroid(s_, j), turn = guide_[i] - guide_[j];
    return std::exp(-dot(way, way) / (2 * sigma_c_ * sigma_c_) - dot(turn, turn) / (2 * sigma_s_ * sigma_s_));
  }

 private:
  const Shape& s_;
  const Normals& guide_;
  double sigma_c_, sigma_s_;
};

/// x of matrix x = right, by elimination with pivots.
Normals solved(Matrix matrix, Normals right) {
  const std::size_t n = right.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t row = k; row < n; ++row) {
      if (std::abs(matrix[row][k]) > std::abs(matrix[pivot][k])) pivot = row;
    }
    std::swap(matrix[k], matrix[pivot]);
    std::swap(right[k], right[pivot]);
    for (std::size_t row = k + 1; row < n; ++row) {
      const double factor = matrix[row][k] / matrix[k][k];
      for (std::size_t column = k; column < n; ++column) matrix[row][column] -= factor * matrix[k][column];
      right[row] -= right[k] * factor;
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t column = k + 1; column < n; ++column) right[k] -= right[column] * matrix[k][column];
    right[k] *= 1 / matrix[k][k];
  }
  return right;
}

/// The normal equations ((1 - lambda) (I - W)^T A (I - W) + lambda A) m = lambda A n.
Normals global(const Shape& s, const Around& around, const BilateralNormalsParams& params, const Normals& n) {
  const std::size_t count = n.size();
  const Bilateral bilateral(s, around, n, params.sigma_c, params.sigma_s);
  Matrix residual(count, std::vector<double>(count)), system = residual;  // I - W
  for (std::size_t i = 0; i < count; ++i) {
    const auto neighbours = near(s, around, i, FaceNeighbourhood::Edges);
    double sum = 0;
    for (const std::size_t j : neighbours) sum += area(s, j) * bilateral(j, i);
    for (const std::size_t j : neighbours) residual[i][j] = -area(s, j) * bilateral(j, i) / sum;
    residual[i][i] = 1;
  }
  Normals right;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t k = 0; k < count; ++k) {
        system[i][j] += (1 - params.lambda) * residual[k][i] * area(s, k) * residual[k][j];
      }
    }
    system[i][i] += params.lambda * area(s, i);
    right.push_back(n[i] * (params.lambda * area(s, i)));
  }
  Normals m = solved(std::move(system), std::move(right));
  std::ranges::transform(m, m.begin(), unit);
  return m;
}

Vec3d median(const Shape& s, const Around& around, const Normals& n, std::size_t f, double edge_weight) {
  struct Neighbour {
    double squared_chord, weight;
    std::size_t face;
  };
  std::vector<Neighbour> all;
  double total = 0, below = 0;
  const auto across = near(s, around, f, FaceNeighbourhood::Edges);
  for (const std::size_t j : near(s, around, f, FaceNeighbourhood::Vertices)) {
    all.push_back({dot(n[j] - n[f], n[j] - n[f]), across.contains(j) ? edge_weight : 1, j});
    total += all.back().weight;
  }
  std::ranges::sort(all, {}, &Neighbour::squared_chord);
  const auto middle = std::ranges::find_if(all, [&](const Neighbour& j) {
    below += j.weight;
    return 2 * below >= total;
  });
  Vec3d sum;
  for (const Neighbour& j : all) {
    if (std::abs(j.squared_chord - middle->squared_chord) <= 1e-3 * middle->squared_chord + 1e-8) {
      sum += n[j.face] * j.weight;
    }
  }
  return unit(sum);
}

}  // namespace

Shape oracle_mean_normals(const Shape& shape, const MeanNormalsParams& params, int iterations) {
  const Around around(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Normals n = averaged(result, around, params.neighbourhood, normals_of(result),
                               [&](std::size_t j, std::size_t) { return area(result, j); });
    result = jacobi(result, around, 1,
                    [&](const Shape& s, Index v) { return s.positions[v] + offset(s, around, n, v, true); });
  }
  return result;
}

Shape oracle_median_normals(const Shape& shape, const MedianNormalsParams& params, int iterations) {
  const Around around(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Normals old = normals_of(result);
    Normals n;
    for (std::size_t f = 0; f < old.size(); ++f)
      n.push_back(median(result, around, old, f, params.edge_weight));
    result = jacobi(result, around, 1,
                    [&](const Shape& s, Index v) { return s.positions[v] + offset(s, around, n, v, true); });
  }
  return result;
}

Shape oracle_fast_effective(const Shape& shape, const FastEffectiveParams& params, int iterations) {
  const Around around(shape);
  Shape result = shape;
  Normals n;
  for (int i = 0; i < iterations; ++i) {
    if (i == 0 || params.filtering == FastEffectiveParams::Filtering::EveryIteration) {
      n = normals_of(result);
      for (unsigned step = 0; step < params.normal_steps; ++step) {
        n = averaged(result, around, params.neighbourhood, n, [&](std::size_t j, std::size_t f) {
          const double cosine = dot(n[j], n[f]);
          return cosine > params.threshold ? std::pow(cosine - params.threshold, 2) : 0;
        });
      }
    }
    result = jacobi(result, around, 1,
                    [&](const Shape& s, Index v) { return s.positions[v] + offset(s, around, n, v, false); });
  }
  return result;
}

Shape oracle_ohtake(const Shape& shape, const OhtakeParams& params, int iterations) {
  const Around around(shape);
  const double h = oracle_mean_edge(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Normals old = normals_of(result);
    const Normals n = averaged(result, around, params.neighbourhood, old, [&](std::size_t j, std::size_t f) {
      const double bending = h * length(old[j] - old[f]) / length(centroid(result, j) - centroid(result, f));
      return area(result, j) * std::exp(-bending * bending / (2 * params.curvature * params.curvature));
    });
    result = jacobi(result, around, 1, [&](const Shape& s, Index v) {
      return s.positions[v] + offset(s, around, n, v, true) +
             tangential(s, around, n, s, v) * params.regularisation;
    });
  }
  return result;
}

Shape oracle_joint_bilateral(const Shape& shape, const JointBilateralParams& params, int iterations) {
  const Around around(shape);
  const double bound = params.distance * oracle_mean_edge(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Shape before = result;
    const auto mean = [&](std::size_t j, std::size_t) { return area(before, j); };
    Normals guide = normals_of(before);
    for (unsigned step = 0; step < params.guide_steps; ++step) {
      guide = averaged(before, around, FaceNeighbourhood::Vertices, guide, mean);
    }
    const Bilateral bilateral(before, around, guide, params.sigma_c, params.sigma_s);
    const Normals n =
        averaged(before, around, FaceNeighbourhood::Vertices, normals_of(before),
                 [&](std::size_t j, std::size_t f) { return area(before, j) * bilateral(j, f); });
    result = jacobi(result, around, static_cast<int>(params.vertex_steps), [&](const Shape& s, Index v) {
      const Vec3d to = s.positions[v] + offset(s, around, n, v, false) +
                       tangential(s, around, n, before, v) * params.laplacian;
      const Vec3d way = to - shape.positions[v];
      return length(way) > bound ? shape.positions[v] + way * (bound / length(way)) : to;
    });
  }
  return result;
}

Shape oracle_bilateral_normals(const Shape& shape, const BilateralNormalsParams& params, int iterations) {
  const Around around(shape);
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Shape before = result;
    Normals n = normals_of(before);
    if (params.scheme == BilateralNormalsParams::Scheme::Global) {
      n = global(before, around, params, n);
    } else {
      for (unsigned step = 0; step < params.normal_steps; ++step) {
        const Normals old = n;
        const Bilateral bilateral(before, around, old, params.sigma_c, params.sigma_s);
        n = averaged(before, around, params.neighbourhood, old,
                     [&](std::size_t j, std::size_t f) { return area(before, j) * bilateral(j, f); });
      }
    }
    result = jacobi(result, around, static_cast<int>(params.vertex_steps),
                    [&](const Shape& s, Index v) { return s.positions[v] + offset(s, around, n, v, false); });
  }
  return result;
}

}  // namespace burnish::testing
