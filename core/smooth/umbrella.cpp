#include "core/smooth/umbrella.h"

namespace burnish {
namespace {

/// Half the sum of the ways to the two vertices along the boundary. An inner edge may join two boundary
/// vertices, so the triangle's side says whether an edge is open, not its ends.
SimdVec3 boundary_umbrella(const Surface& surface, std::span<const SimdVec3> positions, std::size_t vertex) {
  SimdVec3 sum;
  for (const Index f : surface.topology.vertex_faces[vertex]) {
    const Triangle& triangle = surface.mesh.triangles[f];
    for (std::size_t side = 0; side < 3; ++side) {
      if (surface.topology.face_neighbours[f][side] != kNone) continue;
      const Index a = triangle[side], b = triangle[(side + 1) % 3];
      if (a == vertex) sum += positions[b] - positions[vertex];
      if (b == vertex) sum += positions[a] - positions[vertex];
    }
  }
  return sum * 0.5F;
}

}  // namespace

void umbrella_step(const Surface& surface, std::span<const std::uint8_t> movable, float factor,
                   std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
                   std::size_t end) {
  const Topology& topology = surface.topology;
  for (std::size_t v = begin; v < end; ++v) {
    if (!movable[v]) continue;
    const bool open = topology.has(static_cast<Index>(v), kBoundaryVertex);
    const SimdVec3 u = open ? boundary_umbrella(surface, from, v) : umbrella(from, topology, v);
    to[v] = from[v] + u * factor;
  }
}

}  // namespace burnish
