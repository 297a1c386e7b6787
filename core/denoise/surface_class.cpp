#include "core/denoise/surface_class.h"

#include "core/smooth/normal_filter.h"

namespace burnish {

double share_of_flat_edges(const Topology& topology, std::span<const SimdVec3> normals,
                           const RunControl& run) {
  constexpr float kFlatEdge = 0.06F;  // length of the difference of two normals
  const auto& across = topology.face_neighbours;
  const double flat = parallel_sum(across.size(), run, [&](std::size_t begin, std::size_t end) {
    double pairs = 0;
    for (std::size_t f = begin; f < end; ++f) {
      for (const Index g : across[f]) pairs += g != kNone && length(normals[f] - normals[g]) < kFlatEdge;
    }
    return pairs / 2;  // each was met from both sides
  });
  return topology.adjacent_pairs() > 0 ? flat / topology.adjacent_pairs() : 0;
}

double share_of_sharp_bending(const Surface& surface, const RunControl& run) {
  constexpr float kCosine = 0.906F;  // of 25 degrees
  Buffer<SimdVec3> positions(surface.mesh.positions.size());
  Faces faces(surface, FaceNeighbourhood::Edges, run);
  const auto load = [&](std::size_t v) { positions[v] = SimdVec3(surface.mesh.positions[v]); };
  if (!for_each(positions.size(), run, load) || !faces.measure(positions)) return 0;
  const auto bending = [&](float most) {
    return parallel_sum(faces.size(), run, [&](std::size_t begin, std::size_t end) {
      double sum = 0;
      for (std::size_t f = begin; f < end; ++f) {
        const Triangle& corners = surface.mesh.triangles[f];
        for (std::size_t edge = 0; edge < 3; ++edge) {
          const Index g = surface.topology.face_neighbours[f][edge];
          if (g == kNone || faces.twice_area(f) == 0 || faces.twice_area(g) == 0) continue;
          const float cosine = dot(faces.normal(f), faces.normal(g));
          if (cosine >= most) continue;
          const float span = length(positions[corners[edge]] - positions[corners[(edge + 1) % 3]]);
          sum += static_cast<double>((1 - cosine) * span);
        }
      }
      return sum;
    });
  };
  const double all = bending(1);
  return all > 0 ? bending(kCosine) / all : 0;
}

}  // namespace burnish
