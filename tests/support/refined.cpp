#include "tests/support/refined.h"

#include <algorithm>
#include <map>

namespace burnish::testing {
namespace {

constexpr double kCrease = 0.8;  // cosine between normals

using Edge = std::pair<Index, Index>;  // the smaller vertex first

Edge edge_of(const Triangle& t, std::size_t side) { return std::minmax({t[side], t[(side + 1) % 3]}); }

double edge_length(const Shape& shape, const Edge& e) {
  return length(shape.positions[e.first] - shape.positions[e.second]);
}

Vec3d middle(const Shape& shape, const Edge& e) {
  return (shape.positions[e.first] + shape.positions[e.second]) * 0.5;
}

/// The triangles at every edge, of a mesh without edges of three.
std::map<Edge, std::vector<std::size_t>> edges_of(const Shape& shape) {
  std::map<Edge, std::vector<std::size_t>> edges;
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    for (std::size_t side = 0; side < 3; ++side) edges[edge_of(shape.triangles[t], side)].push_back(t);
  }
  return edges;
}

void split(Shape& shape, const Edge& edge, const std::vector<std::size_t>& triangles) {
  const auto at = static_cast<Index>(shape.positions.size());
  shape.positions.push_back(middle(shape, edge));
  for (const std::size_t t : triangles) {
    const Triangle old = shape.triangles[t];
    for (std::size_t side = 0; side < 3; ++side) {
      if (edge_of(old, side) != edge) continue;
      const Index a = old[side], b = old[(side + 1) % 3], c = old[(side + 2) % 3];
      shape.triangles[t] = {a, at, c};
      shape.triangles.push_back({at, b, c});
    }
  }
}

/// Splits what is too long, each triangle at most once; false when nothing was.
bool split_once(Shape& shape, const std::function<double(const Vec3d&)>& size) {
  constexpr double kAbout = 1.3;  // an edge this much shorter than the longest of its triangle may be split
  const auto edges = edges_of(shape);
  std::vector<std::pair<double, Edge>> longest_first;
  for (const auto& [edge, triangles] : edges) {
    const double long_ = edge_length(shape, edge);
    if (long_ > size(middle(shape, edge))) longest_first.emplace_back(-long_, edge);
  }
  std::ranges::sort(longest_first);
  std::vector<bool> used(shape.triangles.size());
  bool any = false;
  for (const auto& [minus_length, edge] : longest_first) {
    const auto& triangles = edges.at(edge);
    const auto may = [&](std::size_t t) {
      if (used[t]) return false;
      for (std::size_t side = 0; side < 3; ++side) {
        if (edge_length(shape, edge_of(shape.triangles[t], side)) > -minus_length * kAbout) return false;
      }
      return true;
    };
    if (!std::ranges::all_of(triangles, may)) continue;
    for (const std::size_t t : triangles) used[t] = true;
    split(shape, edge, triangles);
    any = true;
  }
  return any;
}

Vec3d normal_of(const Shape& shape, std::size_t t) {
  const auto& [a, b, c] = shape.triangles[t];
  const Vec3d n = cross(shape.positions[b] - shape.positions[a], shape.positions[c] - shape.positions[a]);
  return n * (1 / std::max(length(n), 1e-300));
}

}  // namespace

Shape refined(Shape shape, const std::function<double(const Vec3d&)>& size) {
  constexpr int kMostRounds = 12;
  for (int round = 0; round < kMostRounds && split_once(shape, size); ++round) {
  }
  return shape;
}

Shape unevenly_refined(const Shape& shape, Finest finest, std::uint64_t seed) {
  std::vector<Vec3d> creases;
  double mean = 0;
  const auto edges = edges_of(shape);
  for (const auto& [edge, triangles] : edges) {
    mean += edge_length(shape, edge) / static_cast<double>(edges.size());
    const bool sharp = triangles.size() == 2 &&
                       dot(normal_of(shape, triangles[0]), normal_of(shape, triangles[1])) < kCrease;
    if (sharp) creases.push_back(middle(shape, edge));
  }
  Random random(seed);
  const Vec3d slow = random.direction() * 5, fast = random.direction() * 9;
  const double slow_phase = random.between(0, 2 * kPi), fast_phase = random.between(0, 2 * kPi);
  return refined(shape, [&](const Vec3d& p) {
    double square = 1e9;
    for (const Vec3d& c : creases) square = std::min(square, dot(c - p, c - p));
    const double away = std::sqrt(square) / mean;
    const double wave =
        portable_sin(dot(slow, p) + slow_phase) + 0.7 * portable_sin(dot(fast, p) + fast_phase);
    const bool along = finest == Finest::AlongCreases, in_spot = wave > 0.9;
    const double size =
        along ? std::min(1.6, 0.42 + 0.5 * std::max(0.0, away - 0.3)) : std::max(0.42, 1.7 - 0.22 * away);
    return mean * std::max(0.42, size * (!in_spot ? 1 : along ? 0.5 : 0.35));
  });
}

}  // namespace burnish::testing
