#include "core/mesh/topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace burnish {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using namespace burnish::testing;

Topology topology_of(const Shape& shape) { return surface_of(shape).topology; }

TEST(Topology, OfAClosedSphereObeysEuler) {
  const Topology t = topology_of(sphere(3));
  EXPECT_EQ(t.edges, 1920U);  // V - E + F = 642 - 1920 + 1280 = 2
  EXPECT_EQ(t.boundary_edges, 0U);
  EXPECT_EQ(t.non_manifold_edges, 0U);
  EXPECT_EQ(t.components, 1U);
  EXPECT_THAT(t.vertex_flags, Each(0));
  EXPECT_TRUE(t.opposed_neighbours.empty());
}

TEST(Topology, ListsNeighboursInAscendingOrder) {
  const Topology t = topology_of({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}});
  EXPECT_THAT(t.vertex_neighbours[0], ElementsAre(1, 2, 3));
  EXPECT_THAT(t.vertex_neighbours[1], ElementsAre(0, 2));
  EXPECT_THAT(t.vertex_faces[2], ElementsAre(0, 1));
  EXPECT_THAT(t.face_neighbours[0], ElementsAre(kNone, kNone, 1));
  EXPECT_THAT(t.face_neighbours[1], ElementsAre(0, kNone, kNone));
  EXPECT_EQ(t.boundary_edges, 4U);
}

TEST(Topology, FlagsTheRimOfAGrid) {
  const int n = 5;
  const Topology t = topology_of(grid(n));
  EXPECT_EQ(t.boundary_edges, 4U * n);
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      const bool rim = x == 0 || y == 0 || x == n || y == n;
      EXPECT_EQ(t.has(static_cast<Index>(y * (n + 1) + x), kBoundaryVertex), rim);
    }
  }
}

TEST(Topology, FlagsAnEdgeWithThreeTriangles) {
  const Topology t = topology_of(
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}});
  EXPECT_EQ(t.non_manifold_edges, 1U);
  EXPECT_TRUE(t.has(0, kNonManifoldVertex));
  EXPECT_TRUE(t.has(1, kNonManifoldVertex));
  EXPECT_FALSE(t.has(2, kNonManifoldVertex));
  EXPECT_THAT(t.face_neighbours, Each(Each(kNone)));
}

TEST(Topology, FlagsAVertexThatJoinsTwoFans) {
  const Topology t =
      topology_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}});
  EXPECT_EQ(t.non_manifold_vertices, 1U);
  EXPECT_TRUE(t.has(0, kNonManifoldVertex));
  EXPECT_EQ(t.components, 1U);
}

TEST(Topology, KeepsNeighboursThatWindTheOtherWayAndSaysSo) {
  const Topology t = topology_of({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 3, 2}}});
  EXPECT_EQ(t.opposed_edges, 1U);
  EXPECT_EQ(t.face_neighbours[0][2], 1U);
  EXPECT_EQ(t.opposed_neighbours[0], 1U << 2);
  EXPECT_EQ(t.non_manifold_vertices, 0U);
}

TEST(Topology, CountsComponentsAndIsolatedVertices) {
  Shape shape = sphere(1);
  const Shape other = moved(sphere(0), {5, 0, 0});
  const Index first = static_cast<Index>(shape.positions.size());
  shape.positions.insert(shape.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles)
    shape.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  shape.positions.push_back({9, 9, 9});
  const Topology t = topology_of(shape);
  EXPECT_EQ(t.components, 2U);
  EXPECT_EQ(t.isolated_vertices, 1U);
}

TEST(Topology, TakesAFanOfManyTrianglesInItsStride) {
  Shape fan{{{0, 0, 0}}, {}};
  const Index spokes = 200'000;
  for (Index i = 0; i < spokes; ++i)
    fan.positions.push_back({double(i % 1000), double(i / 1000), 1 + double(i % 7)});
  for (Index i = 1; i < spokes; ++i) fan.triangles.push_back({0, i, i + 1});
  const Topology t = topology_of(fan);
  EXPECT_EQ(t.vertex_faces[0].size(), spokes - 1);
  EXPECT_FALSE(t.has(0, kNonManifoldVertex));
}

TEST(Topology, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const Shape shape = sphere(2);
  const auto t = build_topology(shape.positions.size(), shape.triangles, {.stop = source.get_token()});
  ASSERT_FALSE(t);
  EXPECT_EQ(t.error().cause, Cause::Cancelled);
}

TEST(MeanEdgeLength, AveragesEveryEdgeOnce) {
  const Surface s = surface_of({{{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {0, 4, 0}}, {{0, 1, 2}, {0, 2, 3}}});
  EXPECT_NEAR(s.mean_edge * s.mesh.frame.scale(), (3 + 4 + 5 + 3 + 4) / 5.0, 1e-6);
}

}  // namespace
}  // namespace burnish
