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

template <std::size_t kValence, bool kFetchAhead>
void step_group(const ValenceOrder::Group& group, float factor, std::span<const SimdVec3> from,
                std::span<SimdVec3> to) {
  const std::uint32_t* row = group.neighbours.data();
  for (const Index v : group.vertices) {
    if constexpr (kFetchAhead) fetch_ahead(from, to, v);
    SimdVec3 sum = at_doubled(from.data(), row[0]);
    for (std::size_t k = 1; k < kValence; ++k) sum += at_doubled(from.data(), row[k]);
    const SimdVec3 p = from[v];
    to[v] = p + (sum * (1.0F / kValence) - p) * factor;
    row += kValence;
  }
}

}  // namespace

void UmbrellaStep::operator()(float factor, std::span<const SimdVec3> from, std::span<SimdVec3> to,
                              std::size_t begin) const {
  const Topology& topology = surface_.topology;
  const bool ahead = pays_to_fetch_ahead(from.size());
  order_.for_each_group(begin, [&](const ValenceOrder::Group& group) {
    with_constant_valence(group.valence, [&]<std::size_t kValence>() {
      ahead ? step_group<kValence, true>(group, factor, from, to)
            : step_group<kValence, false>(group, factor, from, to);
    });
    if (group.valence != ValenceOrder::kOther) return;
    for (const Index v : group.vertices) {
      const SimdVec3 u = topology.has(v, kBoundaryVertex) ? boundary_umbrella(surface_, from, v)
                                                          : umbrella(from, topology, v);
      to[v] = from[v] + u * factor;
    }
  });
}

}  // namespace burnish
