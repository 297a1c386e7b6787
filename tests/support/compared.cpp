#include "tests/support/compared.h"

#include <gtest/gtest.h>

#include <cmath>

namespace burnish::testing {

Shape shape_on(const Surface& surface, Shape shape) {
  for (std::size_t v = 0; v < shape.positions.size(); ++v) {
    shape.positions[v] = surface.mesh.frame.to_file(to_double(surface.mesh.positions[surface.weld[v]]));
  }
  return shape;
}

Shape smoothed(const Shape& shape, const Smooth& smooth, const IterationOptions& options) {
  Surface surface = surface_of(shape);
  EXPECT_TRUE(smooth(surface, options));
  return shape_on(surface, shape);
}

double largest_distance(const Shape& a, const Shape& b) {
  double worst = 0;
  for (std::size_t v = 0; v < a.positions.size(); ++v) {
    worst = std::max(worst, length(a.positions[v] - b.positions[v]));
  }
  return worst;
}

double mean_edge_of(const Shape& shape) {
  const Surface surface = surface_of(shape);
  return surface.mean_edge * surface.mesh.frame.scale();
}

double deviation(const Shape& shape, const Shape& a, const Shape& b) {
  return largest_distance(a, b) / mean_edge_of(shape);
}

double volume(const Shape& shape) {
  double sum = 0;
  for (const auto& [a, b, c] : shape.triangles) {
    sum += dot(shape.positions[a], cross(shape.positions[b], shape.positions[c])) / 6;
  }
  return sum;
}

double edge_error(const Shape& cube, const Shape& result) {
  double sum = 0, count = 0;
  for (std::size_t v = 0; v < cube.positions.size(); ++v) {
    double error = 0;
    int planes = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(cube.positions[v][axis]) < 1) continue;
      ++planes;
      error += std::pow(result.positions[v][axis] - cube.positions[v][axis], 2);
    }
    if (planes < 2) continue;
    sum += error;
    ++count;
  }
  return std::sqrt(sum / count);
}

const std::vector<Shape>& rough_shapes() {
  static const std::vector<Shape> kShapes = {with_noise(sphere(2), 0.05), with_noise(grid(8), 0.15),
                                             with_noise(cube(5), 0.08)};
  return kShapes;
}

const std::vector<Shape>& various_shapes() {
  static const std::vector<Shape> kShapes = [] {
    std::vector<Shape> all = rough_shapes();
    all.push_back(sphere(1));
    return all;
  }();
  return kShapes;
}

}  // namespace burnish::testing
