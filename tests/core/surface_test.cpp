#include "core/mesh/surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/shapes.h"

namespace burnish {
namespace {

using ::testing::HasSubstr;
using namespace burnish::testing;

std::string vertex_name(Index v) { return "vertex " + std::to_string(v); }
std::string triangle_name(Index t) { return "triangle " + std::to_string(t); }

TEST(PrepareSurface, WeldsEqualPositionsAndMinusZero) {
  const Surface s = surface_of(
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, -0.0, 0}, {0, 1, -0.0}, {1, 1, 0}}, {{0, 1, 2}, {3, 5, 4}}});
  EXPECT_EQ(s.mesh.positions.size(), 4U);
  EXPECT_EQ(s.welded_vertices, 2U);
  EXPECT_EQ(s.weld[3], s.weld[1]);
  EXPECT_EQ(s.topology.boundary_edges, 4U);
  EXPECT_EQ(s.topology.edges, 5U);
}

TEST(PrepareSurface, LeavesOutDegenerateAndDuplicateTriangles) {
  const Surface s = surface_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}},
                                {{0, 1, 2}, {0, 1, 1}, {0, 1, 3}, {2, 0, 1}, {1, 0, 2}}});
  EXPECT_EQ(s.mesh.triangles.size(), 1U);
  EXPECT_EQ(s.degenerate_triangles, 2U);
  EXPECT_EQ(s.first_degenerate, 1U);
  EXPECT_EQ(s.duplicate_triangles, 2U);
  EXPECT_EQ(s.first_duplicate, 3U);
}

TEST(PrepareSurface, CentresAndScalesByAPowerOfTwo) {
  const Surface s = surface_of(moved(scaled(sphere(2), 300), {5e6, -2e6, 17}));
  for (const Vec3f& p : s.mesh.positions) EXPECT_LE(length(p), 1.0F);
  EXPECT_NEAR(s.mesh.frame.centre.x, 5e6, 1);
  EXPECT_EQ(s.mesh.frame.exponent, 10);  // the diagonal is 600 sqrt(3) = 1039
}

TEST(PrepareSurface, GivesTheSameLocalMeshForEveryPowerOfTwo) {
  const Shape shape = with_noise(sphere(2), 0.01);
  const Surface one = surface_of(shape);
  for (const int exponent : {-150, -20, 3, 60, 150}) {
    const Surface other = surface_of(scaled(shape, std::ldexp(1.0, exponent)));
    EXPECT_EQ(one.mesh.positions, other.mesh.positions) << exponent;
  }
}

TEST(PrepareSurface, SurvivesAMeshThatIsOnePoint) {
  const Surface s = surface_of({{{2, 2, 2}, {2, 2, 2}, {2, 2, 2}}, {{0, 1, 2}}});
  EXPECT_EQ(s.mesh.positions.size(), 1U);
  EXPECT_EQ(s.topology.isolated_vertices, 1U);
  EXPECT_EQ(s.mean_edge, 0);
}

TEST(CheckMesh, NamesTheCauseAndThePlace) {
  const Shape good = sphere(0);
  const auto check = [&](const Shape& s) {
    return check_mesh(s.positions, s.triangles, vertex_name, triangle_name);
  };
  EXPECT_TRUE(check(good));
  EXPECT_EQ(check({{}, good.triangles}).error().cause, Cause::EmptyMesh);
  EXPECT_EQ(check({good.positions, {}}).error().cause, Cause::EmptyMesh);

  Shape bad = good;
  bad.positions[7].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(check(bad).error().cause, Cause::NonFinitePosition);
  EXPECT_THAT(check(bad).error().message, HasSubstr("vertex 7: coordinate y"));
  bad.positions[7].y = -1e61;
  EXPECT_EQ(check(bad).error().cause, Cause::NonFinitePosition);

  bad = good;
  bad.triangles[3][1] = 12;
  EXPECT_EQ(check(bad).error(), (Error{Cause::IndexOutOfRange, "triangle 3 uses vertex 12 of 12"}));
}

TEST(SurfaceWarnings, NameEachKindAndItsFirstPlace) {
  Shape shape = grid(2);
  shape.positions.push_back({9, 9, 9});           // isolated
  shape.positions.push_back(shape.positions[0]);  // welded
  shape.triangles.push_back({0, 0, 1});           // degenerate
  shape.triangles.push_back(shape.triangles[0]);  // duplicate
  shape.positions.push_back({0.5, 0.5, 5});
  shape.triangles.push_back({0, 4, 11});  // a third triangle on the diagonal
  const Surface s = surface_of(shape);
  std::vector<std::string> codes;
  for (const Warning& w : surface_warnings(s, vertex_name, triangle_name)) {
    codes.push_back(w.code);
    EXPECT_GT(w.count, 0U) << w.code;
  }
  EXPECT_THAT(codes, ::testing::ElementsAre("welded_vertices", "degenerate_triangles", "duplicate_triangles",
                                            "boundary_edges", "non_manifold_edges", "non_manifold_vertices",
                                            "isolated_vertices"));
  const auto warnings = surface_warnings(s, vertex_name, triangle_name);
  EXPECT_THAT(warnings[1].message, HasSubstr("triangle 8"));
  EXPECT_THAT(warnings[6].message, HasSubstr("vertex 9"));
}

TEST(SurfaceWarnings, AreSilentForACleanMesh) {
  EXPECT_TRUE(surface_warnings(surface_of(sphere(1)), vertex_name, triangle_name).empty());
}

TEST(MovedPositions, AddDisplacementsToFarCoordinatesWithoutLoss) {
  const Shape shape = moved(sphere(1), {1e7, 1e7, 1e7});
  const Surface s = surface_of(shape);
  auto after = s.mesh.positions;
  const double step = 0x1p-20;
  after[5].x += static_cast<float>(step);
  const MovedPositions m{shape.positions, s.weld, s.mesh.positions, after, s.mesh.frame};
  EXPECT_TRUE(m.moved(5));
  EXPECT_FALSE(m.moved(6));
  EXPECT_NEAR(m.at(5).x - shape.positions[5].x, step * s.mesh.frame.scale(), 2e-9);  // an ulp of 1e7
  EXPECT_EQ(m.at(6), shape.positions[6]);
}

TEST(CornerNormals, WeighFacesByTheirAngleAtTheCorner) {
  // A corner of a cube: three right angles, however the sides are cut.
  const Shape shape{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}},
                    {{0, 4, 1}, {0, 2, 4}, {0, 1, 3}, {0, 3, 2}}};
  const Surface s = surface_of(shape);
  auto after = s.mesh.positions;
  const MovedPositions m{shape.positions, s.weld, s.mesh.positions, after, s.mesh.frame};
  const std::vector<Triangle> rows(4, {0, kNone, kNone});
  const auto result = corner_normals(m, shape.triangles, rows, 2, {});
  ASSERT_TRUE(result);
  const float third = -1 / std::sqrt(3.0F);
  EXPECT_NEAR(result->normals[0].x, third, 1e-6);
  EXPECT_NEAR(result->normals[0].y, third, 1e-6);
  EXPECT_NEAR(result->normals[0].z, third, 1e-6);
  EXPECT_EQ(result->normals[1], Vec3f{});
  EXPECT_EQ(result->touched[0], 0);
}

TEST(CornerNormals, AreTouchedOnlyNextToMovedVertices) {
  const Shape shape = sphere(1);
  const Surface s = surface_of(shape);
  auto after = s.mesh.positions;
  after[0].x += 0.1F;
  const MovedPositions m{shape.positions, s.weld, s.mesh.positions, after, s.mesh.frame};
  const auto result = corner_normals(m, shape.triangles, shape.triangles, shape.positions.size(), {});
  ASSERT_TRUE(result);
  for (Index v = 0; v < shape.positions.size(); ++v) {
    bool next = v == 0;
    for (const Index w : s.topology.vertex_neighbours[v]) next = next || w == 0;
    EXPECT_EQ(result->touched[v] != 0, next) << v;
  }
}

}  // namespace
}  // namespace burnish
