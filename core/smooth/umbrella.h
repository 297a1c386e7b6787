// The umbrella operator [10] with equal weights, shared by the filters that are built from it.
//
// [10] L. Kobbelt, S. Campagna, J. Vorsatz, H.-P. Seidel, Interactive multi-resolution modeling on arbitrary
// meshes,
//      SIGGRAPH 1998, 105-114.
#pragma once

#include "core/mesh/simd_vec3.h"
#include "core/mesh/surface.h"
#include "core/smooth/valence_order.h"

namespace burnish {

/// U(v) (Eq. 3, w = 1): mean of the neighbours minus v; zero for an isolated vertex.
inline SimdVec3 umbrella(std::span<const SimdVec3> positions, const Topology& topology, std::size_t vertex) {
  const auto neighbours = topology.vertex_neighbours[vertex];
  if (neighbours.empty()) return {};
  SimdVec3 sum;
  for (const Index w : neighbours) sum += positions[w];
  return sum * (1.0F / static_cast<float>(neighbours.size())) - positions[vertex];
}

/// Steps v' = v + factor U(v) of the movable vertices; a boundary vertex is averaged with its two neighbours
/// along the boundary only. Reads the topology and triangles of the surface, not its positions. Thread-safe.
class UmbrellaStep {
 public:
  UmbrellaStep(const Surface& surface, std::span<const std::uint8_t> movable, const RunControl& run = {})
      : surface_(surface), order_(surface.topology, movable, run) {}

  /// For the block of vertices that starts at `begin`, as parallel_for hands it out.
  void operator()(float factor, std::span<const SimdVec3> from, std::span<SimdVec3> to,
                  std::size_t begin) const;

 private:
  const Surface& surface_;
  ValenceOrder order_;
};

}  // namespace burnish
