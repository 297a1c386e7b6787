#include "tests/support/oracle_guided.h"

#include <algorithm>
#include <cmath>

#include "tests/support/around.h"

namespace burnish::testing {
namespace {

using Normals = std::vector<Vec3d>;
using Faces = std::set<std::size_t>;

Vec3d unit(const Vec3d& a) { return a * (1 / length(a)); }
double area(const Shape& s, std::size_t f) { return length(normal_times_area(s, f)); }
double gaussian(double x, double sigma) { return std::exp(-x * x / (2 * sigma * sigma)); }

Normals normals_of(const Shape& s) {
  Normals normals;
  for (std::size_t f = 0; f < s.triangles.size(); ++f) normals.push_back(unit(normal_times_area(s, f)));
  return normals;
}

double mean_centroid_distance(const Shape& s, const Around& around) {
  double sum = 0, pairs = 0;
  for (const auto& [edge, at] : around.edge_faces) {
    if (at.size() != 2) continue;
    sum += length(centroid(s, at[0]) - centroid(s, at[1]));
    ++pairs;
  }
  return sum / pairs;
}

/// f and the triangles that share a vertex with it.
Faces patch(const Shape& s, const Around& around, std::size_t f) {
  Faces result;
  for (const Index v : s.triangles[f]) result.insert(around.faces[v].begin(), around.faces[v].end());
  return result;
}

/// The patch, and all within the radius that a walk from f within the radius meets.
Faces neighbours_within(const Shape& s, const Around& around, std::size_t f, double radius) {
  Faces met = {f};
  for (std::vector<std::size_t> way = {f}; !way.empty();) {
    const Faces next = patch(s, around, way.back());
    way.pop_back();
    for (const std::size_t j : next) {
      if (length(centroid(s, j) - centroid(s, f)) <= radius && met.insert(j).second) way.push_back(j);
    }
  }
  met.merge(patch(s, around, f));
  return met;
}

/// Phi R, with R over the edges at the corners of f.
double consistency(const Shape& s, const Around& around, const Normals& n, std::size_t f) {
  const Faces faces = patch(s, around, f);
  double phi = 0, sum = 0, most = 0;
  for (const std::size_t a : faces) {
    for (const std::size_t b : faces) phi = std::max(phi, length(n[a] - n[b]));
  }
  std::set<std::pair<Index, Index>> edges;
  for (const Index v : s.triangles[f]) {
    for (const Index w : around.neighbours[v]) edges.insert(std::minmax(v, w));
  }
  for (const auto& edge : edges) {
    const auto& at = around.edge_faces.at(edge);
    const double turn = at.size() == 2 ? length(n[at[0]] - n[at[1]]) : 0;
    sum += turn;
    most = std::max(most, turn);
  }
  return phi * most / (1e-9 + sum);
}

Normals guidance(const Shape& s, const Around& around, const Normals& n) {
  std::vector<double> h;
  Normals means, result;
  for (std::size_t f = 0; f < n.size(); ++f) {
    Vec3d sum;
    for (const std::size_t j : patch(s, around, f)) sum += n[j] * area(s, j);
    means.push_back(unit(sum));
    h.push_back(consistency(s, around, n, f));
  }
  for (std::size_t f = 0; f < n.size(); ++f) {
    const Faces faces = patch(s, around, f);
    result.push_back(means[*std::ranges::min_element(faces, {}, [&](std::size_t j) { return h[j]; })]);
  }
  return result;
}

/// unit(sum of weight(j, i) n(j)) over near(i), n(i) where the weights vanish.
template <class Near, class Weight>
Normals averaged(const Normals& n, Near&& near, Weight&& weight) {
  Normals result;
  for (std::size_t i = 0; i < n.size(); ++i) {
    Vec3d sum;
    double weights = 0;
    for (const std::size_t j : near(i)) {
      sum += n[j] * weight(j, i);
      weights += weight(j, i);
    }
    result.push_back(length(sum) > 1e-6 * weights ? unit(sum) : n[i]);
  }
  return result;
}

/// The gradient of the volume, by differences: it is linear in every vertex.
Vec3d volume_gradient(const Shape& s, const Around& around, Index v) {
  Vec3d gradient;
  for (const std::size_t f : around.faces[v]) {
    Triangle t = s.triangles[f];
    std::ranges::rotate(t, std::ranges::find(t, v));
    gradient += cross(s.positions[t[1]], s.positions[t[2]]) * (1.0 / 6);
  }
  return gradient;
}

}  // namespace

Shape oracle_guided(const Shape& shape, const GuidedParams& params, int iterations) {
  const Around around(shape);
  const double radius = params.radius * mean_centroid_distance(shape, around);
  std::vector<Faces> near;
  for (std::size_t f = 0; f < shape.triangles.size(); ++f) {
    near.push_back(neighbours_within(shape, around, f, radius));
  }
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Shape before = result;
    const double sigma_s = params.sigma_s * mean_centroid_distance(before, around);
    Normals n = normals_of(before);
    for (unsigned step = 0; step < params.normal_steps; ++step) {
      const Normals g = guidance(before, around, n);
      n = averaged(
          n, [&](std::size_t f) { return near[f]; },
          [&](std::size_t j, std::size_t f) {
            return area(before, j) * gaussian(length(centroid(before, j) - centroid(before, f)), sigma_s) *
                   gaussian(length(g[j] - g[f]), params.sigma_r);
          });
    }
    result = jacobi(result, around, static_cast<int>(params.vertex_steps), [&](const Shape& s, Index v) {
      Vec3d sum;
      for (const std::size_t f : around.faces[v]) sum += n[f] * dot(centroid(s, f) - s.positions[v], n[f]);
      return s.positions[v] + sum * (1.0 / static_cast<double>(around.faces[v].size()));
    });
  }
  return result;
}

Shape oracle_robust_normals(const Shape& shape, const RobustNormalsParams& params, int iterations) {
  const Around around(shape);
  const auto moves = [&](Index v) { return !around.boundary[v] && !around.faces[v].empty(); };
  Shape result = shape;
  for (int i = 0; i < iterations; ++i) {
    const Shape before = result;
    const double sigma_c = params.sigma_c * mean_centroid_distance(before, around);
    const auto near = [&](std::size_t f) {
      Faces faces = patch(before, around, f);
      faces.erase(f);
      return faces;
    };
    const auto filtered = [&](const Normals& n, const Normals& guide, double threshold) {
      return averaged(n, near, [&](std::size_t j, std::size_t f) {
        const double x = length(guide[j] - guide[f]) / threshold;
        return area(before, j) * gaussian(length(centroid(before, j) - centroid(before, f)), sigma_c) *
               (x < 1 ? std::pow(1 - x * x, 2) : 0);
      });
    };
    Normals n = normals_of(before), m = n;
    for (unsigned step = 0; step < params.normal_steps; ++step) m = filtered(m, m, params.first_threshold);
    for (unsigned step = 0; step < params.normal_steps; ++step) n = filtered(n, m, params.second_threshold);
    for (unsigned step = 0; step < params.vertex_steps; ++step) {
      Normals ways(result.positions.size());
      double gained = 0, sizes = 0;
      for (Index v = 0; v < ways.size(); ++v) {
        if (!moves(v)) continue;
        double areas = 0;
        for (const std::size_t f : around.faces[v]) {
          Vec3d edges;
          for (const Index w : result.triangles[f]) edges += result.positions[w] - result.positions[v];
          ways[v] += n[f] * (area(before, f) * dot(edges, n[f]) / 3);
          areas += area(before, f);
        }
        ways[v] *= 1 / areas;
        gained += dot(volume_gradient(result, around, v), ways[v]);
        sizes += length(volume_gradient(result, around, v));
      }
      result = jacobi(result, around, 1, [&](const Shape& s, Index v) {
        return s.positions[v] + ways[v] - unit(volume_gradient(s, around, v)) * (gained / sizes);
      });
    }
  }
  return result;
}

}  // namespace burnish::testing
