#include "core/denoise/facets.h"

#include <algorithm>

#include "core/smooth/bilateral_filter.h"

namespace burnish {
namespace {

constexpr std::uint32_t kRings = 12;
/// Widths of the bilateral filter, and moves of the vertices after each.
constexpr BilateralWidths kWidths{.sigma_c = 1, .sigma_s = 0.2};
constexpr std::uint32_t kVertexSteps = 2;

/// From 0 to 1 between the two, without a corner.
float between(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

/// Of edges: bending at sharp ones, bending at all, share of flat ones.
using Edges = SimdVec3;

Edges edges_of(const Faces& faces, std::span<const SimdVec3> positions, std::size_t f) {
  constexpr float kSharpCosine = 0.906F, kFlat = 0.15F;
  const Triangle& corners = faces.surface().mesh.triangles[f];
  float sharp = 0, all = 0, flat = 0, count = 0;
  for (std::size_t edge = 0; edge < 3; ++edge) {
    const Index g = faces.surface().topology.face_neighbours[f][edge];
    if (g == kNone) continue;
    const float cosine = dot(faces.normal(f), faces.normal(g));
    const float bending =
        (1 - cosine) * length(positions[corners[edge]] - positions[corners[(edge + 1) % 3]]);
    all += bending;
    if (cosine < kSharpCosine) sharp += bending;
    flat += length(faces.normal(f) - faces.normal(g)) < kFlat ? 1.0F : 0.0F;
    count += 1;
  }
  return {sharp, all, count > 0 ? flat / count : 0};
}

}  // namespace

bool weigh_facets(const Faces& faces, std::span<const SimdVec3> positions, std::span<float> weights) {
  const RunControl& run = faces.run();
  Buffer<Edges> edges(faces.size()), next(faces.size());
  bool going = for_each(faces.size(), run, [&](std::size_t f) { edges[f] = edges_of(faces, positions, f); });
  for (std::uint32_t ring = 0; going && ring < kRings; ++ring) {
    going = for_each(faces.size(), run, [&](std::size_t f) {
      Edges sum = edges[f];
      float count = 1;
      faces.for_each_neighbour(f, [&](Index n) {
        sum += edges[n];
        count += 1;
      });
      next[f] = sum * (1 / count);
    });
    edges.swap(next);
  }
  return going && for_each(faces.size(), run, [&](std::size_t f) {
           const float sharp = edges[f].x(), all = edges[f].y(), flat = edges[f].z();
           weights[f] = all > 0 ? between(0.5F, 0.8F, sharp / all) * between(0.6F, 0.75F, flat) : 0;
         });
}

bool smooth_facets(Faces& faces, std::span<const std::uint8_t> movable, std::uint32_t steps,
                   Buffer<SimdVec3>& now, Buffer<SimdVec3>& next) {
  const RunControl& run = faces.run();
  const auto& vertex_faces = faces.surface().topology.vertex_faces;
  Buffer<float> weights(faces.size());
  Buffer<std::uint8_t> moves(movable.size());
  const auto weighs = [&](Index f) { return weights[f] > 0; };
  bool going = faces.measure(now) && weigh_facets(faces, now, weights);
  if (going && std::ranges::none_of(weights, [](float weight) { return weight > 0; })) return true;
  going = going && for_each(movable.size(), run, [&](std::size_t v) {
            moves[v] = movable[v] != 0 && std::ranges::any_of(vertex_faces[v], weighs);
          });
  for (std::uint32_t step = 0; going && step < steps; ++step) {
    if (!faces.measure(now)) return false;
    const BilateralExponent exponent(kWidths, faces, faces.normals());
    going = faces.filter_with(WeightedNeighbours{}, [&](WeightedNeighbours& near, std::size_t f) {
      const SimdVec3 own = faces.normal(f);
      if (!weighs(static_cast<Index>(f))) return own;
      const SimdVec3 filtered =
          normal_by_weights(faces, near, f, exponent, [](Index, std::size_t) { return 1.0F; });
      return unit_or(own * (1 - weights[f]) + filtered * weights[f], 1, own);
    });
    for (std::uint32_t move = 0; going && move < kVertexSteps; ++move) {
      going = faces.measure_centroids(now) && for_each(now.size(), run, [&](std::size_t v) {
                if (moves[v] != 0) next[v] = now[v] + faces.offset_by_count(now[v], v);
              });
      now.swap(next);
    }
  }
  return going && for_each(now.size(), run, [&](std::size_t v) {
           if (moves[v] != 0) next[v] = now[v];
         });
}

}  // namespace burnish
