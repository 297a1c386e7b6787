// The shapes that denoising is measured on must themselves be beyond doubt.
#include "tests/support/procedural.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/run/math.h"
#include "tests/support/delaunay.h"
#include "tests/support/irregular.h"

namespace burnish::testing {
namespace {

constexpr std::size_t kResolution = 5000;

double volume(const Shape& shape) {
  double six = 0;
  for (const auto& [a, b, c] : shape.triangles) {
    six += dot(shape.positions[a], cross(shape.positions[b], shape.positions[c]));
  }
  return six / 6;
}

double least_angle(const Shape& shape) {
  double smallest = 180;
  for (const auto& [a, b, c] : shape.triangles) {
    smallest = std::min(smallest, smallest_angle(shape.positions[a], shape.positions[b], shape.positions[c]));
  }
  return smallest;
}

Vec3d unit_normal(const Shape& shape, Index triangle) {
  const auto& [a, b, c] = shape.triangles[triangle];
  const Vec3d n = cross(shape.positions[b] - shape.positions[a], shape.positions[c] - shape.positions[a]);
  return n * (1 / length(n));
}

/// Edges whose triangles' normals differ by more than this many degrees.
std::size_t edges_sharper_than(const Shape& shape, const Topology& topology, double degrees) {
  std::size_t sharp = 0;
  for (Index t = 0; t < shape.triangles.size(); ++t) {
    for (const Index n : topology.face_neighbours[t]) {
      if (n == kNone || n < t) continue;
      const double cosine = dot(unit_normal(shape, t), unit_normal(shape, n));
      sharp += cosine < portable_cos(degrees / kDegreesPerRadian) ? 1 : 0;
    }
  }
  return sharp;
}

class Procedural : public ::testing::TestWithParam<std::tuple<std::string, std::uint64_t>> {
 protected:
  const NamedShape named_ = procedural_shape(std::get<0>(GetParam()), std::get<1>(GetParam()), kResolution);
  const Shape& shape_ = named_.shape;
  const Surface surface_ = surface_of(shape_);
};

TEST_P(Procedural, IsOneManifold) {
  const Topology& topology = surface_.topology;
  EXPECT_EQ(surface_.welded_vertices + surface_.degenerate_triangles + surface_.duplicate_triangles, 0u);
  EXPECT_EQ(topology.non_manifold_edges, 0u);
  EXPECT_EQ(topology.opposed_edges, 0u);
  EXPECT_EQ(topology.non_manifold_vertices, 0u);
  EXPECT_EQ(topology.isolated_vertices, 0u);
  EXPECT_EQ(topology.boundary_edges == 0, named_.closed) << topology.boundary_edges << " boundary edges";
  EXPECT_TRUE(named_.closed || topology.components == 1);
}

TEST_P(Procedural, WindsOutwards) {
  if (named_.closed) {
    EXPECT_GT(volume(shape_), 0.1);
  } else {
    for (Index t = 0; t < shape_.triangles.size(); ++t)
      ASSERT_GT(unit_normal(shape_, t).z, 0.0) << "triangle " << t;
  }
}

TEST_P(Procedural, HasNoDegenerateTriangleAndNoFold) {
  EXPECT_GT(least_angle(shape_), 3.0);
  EXPECT_EQ(edges_sharper_than(shape_, surface_.topology, 135), 0u);
}

TEST_P(Procedural, HasTheSizeAskedFor) {
  EXPECT_NEAR(static_cast<double>(shape_.triangles.size()), kResolution, 0.1 * kResolution);
}

TEST_P(Procedural, IsIrregular) {
  double sum = 0, squares = 0;
  std::size_t count = 0, six = 0;
  for (Index v = 0; v < surface_.mesh.positions.size(); ++v) {
    six += surface_.topology.vertex_neighbours[v].size() == 6 ? 1 : 0;
    for (const Index w : surface_.topology.vertex_neighbours[v]) {
      const double size =
          length(to_double(surface_.mesh.positions[w]) - to_double(surface_.mesh.positions[v]));
      sum += size, squares += size * size, ++count;
    }
  }
  const auto edges = static_cast<double>(count);
  const double spread = std::sqrt(squares / edges - (sum / edges) * (sum / edges)) / (sum / edges);
  EXPECT_GT(spread, 0.2);  // standard deviation of the edges over their mean
  EXPECT_LT(static_cast<double>(six), 0.6 * static_cast<double>(surface_.mesh.positions.size()));
}

TEST_P(Procedural, HasSharpEdgesWhenMachined) {
  const std::size_t sharp = edges_sharper_than(shape_, surface_.topology, 40);
  EXPECT_TRUE(named_.family == Family::FreeForm || sharp > 20) << sharp;
}

std::string test_name(const ::testing::TestParamInfo<std::tuple<std::string, std::uint64_t>>& info) {
  return std::get<0>(info.param) + "_seed" + std::to_string(std::get<1>(info.param));
}
INSTANTIATE_TEST_SUITE_P(Shapes, Procedural,
                         ::testing::Combine(::testing::ValuesIn(procedural_names()),
                                            ::testing::Values(1u, 2u)),
                         test_name);

TEST(ProceduralShapes, RepeatThemselvesForASeedOnly) {
  for (const std::string& name : procedural_names()) {
    const Shape once = procedural_shape(name, 3, 2000).shape, again = procedural_shape(name, 3, 2000).shape;
    EXPECT_EQ(once.positions, again.positions) << name;
    EXPECT_EQ(once.triangles, again.triangles) << name;
    EXPECT_NE(once.positions, procedural_shape(name, 4, 2000).shape.positions) << name;
  }
}

TEST(ProceduralShapes, AreOfEveryFamilyOpenAndClosed) {
  const auto shapes = procedural_shapes(1, 1000);
  EXPECT_GE(shapes.size(), 14u);
  std::set<std::pair<Family, bool>> found;
  for (const NamedShape& s : shapes) found.emplace(s.family, s.closed);
  EXPECT_THAT(found, ::testing::IsSupersetOf({std::pair{Family::Machined, true},
                                              {Family::FreeForm, true},
                                              {Family::FreeForm, false},
                                              {Family::Mixed, true}}));
}

TEST(Delaunay, LeavesNoPointInACircleAndCoversTheHull) {
  Random random(5);
  std::vector<Point2> points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int i = 0; i < 60; ++i) points.push_back({random.unit(), random.unit()});
  double area = 0;
  for (const auto& [a, b, c] : delaunay(points)) {
    const double ax = points[b].x - points[a].x, ay = points[b].y - points[a].y;
    const double bx = points[c].x - points[a].x, by = points[c].y - points[a].y;
    area += (ax * by - ay * bx) / 2;
    for (Index v = 0; v < points.size(); ++v) {  // the sign of the in-circle determinant
      if (v == a || v == b || v == c) continue;
      const auto row = [&](Index i) {
        const double x = points[i].x - points[v].x, y = points[i].y - points[v].y;
        return Vec3d{x, y, x * x + y * y};
      };
      EXPECT_LT(dot(row(a), cross(row(b), row(c))), 1e-12);
    }
  }
  EXPECT_NEAR(area, 1, 1e-12);
}

}  // namespace
}  // namespace burnish::testing
