// The topology of random triangles, among them every kind of odd edge and vertex, against plain definitions.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "core/mesh/topology.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace burnish::testing;

struct Use {
  Index face, side;
  bool operator==(const Use&) const = default;
};
using Edge = std::pair<Index, Index>;

std::map<Edge, std::vector<Use>> edges_of(const std::vector<Triangle>& triangles) {
  std::map<Edge, std::vector<Use>> edges;
  for (Index f = 0; f < triangles.size(); ++f) {
    for (Index e = 0; e < 3; ++e) {
      edges[std::minmax({triangles[f][e], triangles[f][(e + 1) % 3]})].push_back({f, e});
    }
  }
  return edges;
}

/// Sets of triangles at a vertex that hang together across edges of two triangles.
std::size_t fans_at(Index vertex, const std::vector<Triangle>& triangles,
                    const std::map<Edge, std::vector<Use>>& edges) {
  std::map<Index, Index> fan;  // each triangle's: a triangle that stands for it
  for (Index f = 0; f < triangles.size(); ++f) {
    for (const Index v : triangles[f]) {
      if (v == vertex) fan[f] = f;
    }
  }
  for (const auto& [edge, uses] : edges) {
    if (uses.size() != 2 || (edge.first != vertex && edge.second != vertex)) continue;
    const Index from = fan[uses[0].face], to = fan[uses[1].face];
    for (auto& [face, stands] : fan) stands = stands == from ? to : stands;
  }
  std::set<Index> different;
  for (const auto& [face, stands] : fan) different.insert(stands);
  return different.size();
}

void expect_plain_definitions(Index vertices, const std::vector<Triangle>& triangles, const Topology& t) {
  const auto edges = edges_of(triangles);
  std::vector<std::set<Index>> neighbours(vertices), faces(vertices);
  std::vector<std::uint8_t> flags(vertices, 0);
  std::uint32_t boundary = 0, non_manifold = 0, opposed = 0;
  for (const auto& [edge, uses] : edges) {
    const auto [a, b] = edge;
    neighbours[a].insert(b);
    neighbours[b].insert(a);
    boundary += uses.size() == 1;
    non_manifold += uses.size() > 2;
    for (const Index v : {a, b})
      flags[v] |= uses.size() == 1 ? kBoundaryVertex : uses.size() > 2 ? kNonManifoldVertex : 0;
    const bool same_way =
        uses.size() == 2 && triangles[uses[0].face][uses[0].side] == triangles[uses[1].face][uses[1].side];
    opposed += same_way;
    for (std::size_t i = 0; i < uses.size(); ++i) {
      const auto [face, side] = uses[i];
      EXPECT_EQ(t.face_neighbours[face][side], uses.size() == 2 ? uses[1 - i].face : kNone);
      EXPECT_EQ(t.opposed(face, side), same_way);
    }
  }
  for (Index f = 0; f < triangles.size(); ++f) {
    for (const Index v : triangles[f]) faces[v].insert(f);
  }
  std::uint32_t isolated = 0, odd = 0;
  for (Index v = 0; v < vertices; ++v) {
    if (faces[v].empty())
      flags[v] = kIsolatedVertex;
    else if (fans_at(v, triangles, edges) > 1)
      flags[v] |= kNonManifoldVertex;
    isolated += faces[v].empty();
    odd += (flags[v] & kNonManifoldVertex) != 0;
    EXPECT_EQ(std::vector<Index>(t.vertex_neighbours[v].begin(), t.vertex_neighbours[v].end()),
              std::vector<Index>(neighbours[v].begin(), neighbours[v].end()));
    EXPECT_EQ(std::vector<Index>(t.vertex_faces[v].begin(), t.vertex_faces[v].end()),
              std::vector<Index>(faces[v].begin(), faces[v].end()));
  }
  EXPECT_EQ(t.vertex_flags, flags);
  EXPECT_EQ(t.edges, edges.size());
  EXPECT_EQ(t.boundary_edges, boundary);
  EXPECT_EQ(t.non_manifold_edges, non_manifold);
  EXPECT_EQ(t.opposed_edges, opposed);
  EXPECT_EQ(t.isolated_vertices, isolated);
  EXPECT_EQ(t.non_manifold_vertices, odd);
  std::vector<Index> component(vertices);
  for (Index v = 0; v < vertices; ++v) component[v] = v;
  for (const auto& [edge, uses] : edges) {
    const Index from = component[edge.first], to = component[edge.second];
    for (Index& c : component) c = c == from ? to : c;
  }
  EXPECT_EQ(t.components, std::set<Index>(component.begin(), component.end()).size() - isolated);
}

/// Random triangles with different corner sets.
std::vector<Triangle> soup(Index vertices, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::set<std::set<Index>> taken;
  std::vector<Triangle> triangles;
  while (triangles.size() < count) {
    const auto any = [&] { return static_cast<Index>(random() % vertices); };
    const Triangle t{any(), any(), any()};
    const std::set<Index> corners(t.begin(), t.end());
    if (corners.size() == 3 && taken.insert(corners).second) triangles.push_back(t);
  }
  return triangles;
}

TEST(TopologyOracle, AgreesForRandomTriangles) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Index vertices = 6 + static_cast<Index>(seed % 20);
    const auto triangles = soup(vertices, 1 + seed % 19, seed);
    const auto topology = build_topology(vertices, triangles, {});
    EXPECT_FALSE(topology->repeated_triangles);
    expect_plain_definitions(vertices, triangles, *topology);
  }
}

TEST(TopologyOracle, AgreesForSurfacesWithTrianglesTurnedAndTakenAway) {
  std::mt19937_64 random(5);
  for (const Shape& shape : {sphere(1), grid(4), cube(2)}) {
    const Surface whole = surface_of(shape);
    for (int holes = 0; holes < 12; holes += 4) {
      auto triangles = whole.mesh.triangles;
      for (int i = 0; i < holes; ++i) {
        std::swap(triangles[random() % triangles.size()], triangles.back());
        triangles.pop_back();
        auto& turned = triangles[random() % triangles.size()];
        std::swap(turned[0], turned[1]);
      }
      const auto vertices = static_cast<Index>(whole.mesh.positions.size());
      expect_plain_definitions(vertices, triangles, *build_topology(vertices, triangles, {}));
    }
  }
}

TEST(TopologyOracle, AgreesForClosedFansThatMeetInAVertex) {
  for (Index fans = 1; fans < 4; ++fans) {
    for (Index size = 3; size < 7; ++size) {
      std::vector<Triangle> triangles;
      for (Index fan = 0; fan < fans; ++fan) {
        const auto rim = [&](Index i) { return 1 + fan * size + i % size; };
        for (Index i = 0; i < size; ++i) triangles.push_back({rim(i), rim(i + 1), 0});
      }
      const Index vertices = 1 + fans * size;
      expect_plain_definitions(vertices, triangles, *build_topology(vertices, triangles, {}));
    }
  }
}

TEST(TopologyOracle, SeesEveryRepeatedTriangle) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    auto triangles = seed % 2 == 0 ? soup(12, 10, seed) : surface_of(sphere(1)).mesh.triangles;
    Triangle again = triangles[seed % triangles.size()];
    if (seed % 4 < 2) std::swap(again[0], again[1]);
    std::rotate(again.begin(), again.begin() + seed % 3, again.end());
    triangles.insert(triangles.begin() + static_cast<std::ptrdiff_t>(seed % 7), again);
    EXPECT_TRUE(build_topology(42, triangles, {})->repeated_triangles) << seed;
  }
}

TEST(TopologyOracle, IsTheSameForAnyNumberOfThreads) {
  const Shape shape = with_noise(sphere(7), 0.001);  // large enough for parts of the counting sort
  const Surface one = surface_of(shape);
  const auto two = prepare_surface(shape.positions, shape.triangles, {.threads = 2});
  EXPECT_EQ(one.weld, two->weld);
  EXPECT_EQ(one.mesh.positions, two->mesh.positions);
  EXPECT_EQ(one.mesh.triangles, two->mesh.triangles);
  EXPECT_EQ(one.source_triangle, two->source_triangle);
  EXPECT_EQ(one.topology.vertex_faces.items, two->topology.vertex_faces.items);
  EXPECT_EQ(one.topology.vertex_neighbours.items, two->topology.vertex_neighbours.items);
  EXPECT_EQ(one.topology.vertex_neighbours.offsets, two->topology.vertex_neighbours.offsets);
  EXPECT_EQ(one.topology.face_neighbours, two->topology.face_neighbours);
  EXPECT_EQ(one.mean_edge, two->mean_edge);
}

}  // namespace
}  // namespace burnish
