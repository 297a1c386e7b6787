// Neighbourhoods the slow way, and the loop that all oracles share.
#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tests/support/shapes.h"

namespace burnish::testing {

struct Around {
  std::vector<std::set<Index>> neighbours;
  std::vector<std::vector<std::size_t>> faces;
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> edge_faces;
  std::vector<bool> boundary;

  explicit Around(const Shape& shape)
      : neighbours(shape.positions.size()), faces(shape.positions.size()), boundary(shape.positions.size()) {
    for (std::size_t f = 0; f < shape.triangles.size(); ++f) {
      const Triangle& t = shape.triangles[f];
      for (int e = 0; e < 3; ++e) {
        const Index a = t[e], b = t[(e + 1) % 3];
        neighbours[a].insert(b);
        neighbours[b].insert(a);
        faces[a].push_back(f);
        edge_faces[std::minmax(a, b)].push_back(f);
      }
    }
    for (const auto& [edge, at] : edge_faces) {
      if (at.size() == 1) boundary[edge.first] = boundary[edge.second] = true;
    }
  }
};

inline Vec3d normal_times_area(const Shape& shape, std::size_t f) {
  const Triangle& t = shape.triangles[f];
  const Vec3d &a = shape.positions[t[0]], &b = shape.positions[t[1]], &c = shape.positions[t[2]];
  return cross(b - a, c - a) * 0.5;
}

inline Vec3d centroid(const Shape& shape, std::size_t f) {
  const Triangle& t = shape.triangles[f];
  return (shape.positions[t[0]] + shape.positions[t[1]] + shape.positions[t[2]]) * (1.0 / 3);
}

/// step(shape, v) gives the new position of each inner vertex from the old shape.
template <class Step>
Shape jacobi(Shape shape, const Around& around, int iterations, Step&& step) {
  for (int i = 0; i < iterations; ++i) {
    Shape next = shape;
    for (Index v = 0; v < shape.positions.size(); ++v) {
      if (!around.boundary[v] && !around.faces[v].empty()) next.positions[v] = step(shape, v);
    }
    shape = std::move(next);
  }
  return shape;
}

}  // namespace burnish::testing
