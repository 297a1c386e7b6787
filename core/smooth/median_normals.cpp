#include "core/smooth/median_normals.h"

#include <algorithm>

#include "core/smooth/parameters.h"

namespace burnish {
namespace {

struct Neighbour {
  float squared_chord;  // |n(S) - n(T)|^2 grows with the angle, and rounds less than the dot product
  float weight;
  Index face;
};

/// The weighted median of the neighbours, which must not be empty, and those that tie with it, averaged.
SimdVec3 median(std::span<Neighbour> neighbours, const Faces& faces, SimdVec3 own) {
  std::ranges::sort(neighbours, {}, &Neighbour::squared_chord);
  float total = 0;
  for (const Neighbour& n : neighbours) total += n.weight;
  std::size_t middle = 0;
  for (float below = neighbours[0].weight; 2 * below < total && middle + 1 < neighbours.size();) {
    below += neighbours[++middle].weight;
  }
  const float at = neighbours[middle].squared_chord, tie = 1e-3F * at + 1e-8F;
  SimdVec3 sum;
  float weights = 0;
  for (const Neighbour& n : neighbours) {
    if (std::abs(n.squared_chord - at) > tie) continue;
    sum += faces.normal(n.face) * n.weight;
    weights += n.weight;
  }
  return unit_or(sum, weights, own);
}

bool filter(Faces& faces, float edge_weight) {
  return faces.filter_with(std::vector<Neighbour>{}, [&](std::vector<Neighbour>& neighbours, std::size_t f) {
    const SimdVec3 own = faces.normal(f);
    const Triangle& across = faces.surface().topology.face_neighbours[f];
    neighbours.clear();
    faces.for_each_neighbour(f, [&](Index n) {
      if (faces.twice_area(n) == 0) return;
      const SimdVec3 chord = faces.normal(n) - own;
      const bool by_edge = n == across[0] || n == across[1] || n == across[2];
      neighbours.push_back({dot(chord, chord), by_edge ? edge_weight : 1.0F, n});
    });
    return neighbours.empty() ? own : median(neighbours, faces, own);
  });
}

}  // namespace

Result<SmoothOutcome> smooth_median_normals(Surface& surface, const MedianNormalsParams& params,
                                            const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  const float edge_weight = static_cast<float>(params.edge_weight);
  return iterate_normals(
      surface, faces, constraints, options,
      {.filter = [&](auto from) { return faces.measure(from) && filter(faces, edge_weight); },
       .move =
           move_by(constraints, [&](auto from, std::size_t v) { return faces.offset_by_area(from[v], v); })});
}

Method median_normals_method() {
  constexpr MedianNormalsParams kDefaults;
  return {.name = "median_normals",
          .summary =
              "Replaces every face normal by the one at the weighted median of the angles to its neighbours' "
              "and moves the vertices to fit; keeps edges.",
          .reference =
              "H. Yagou, Y. Ohtake, A. Belyaev, Mesh smoothing via mean and median filtering applied to face "
              "normals, Geometric Modeling and Processing 2002, 124-131",
          .formula =
              "v' = v + 1/sum A(T) sum A(T) [(c(T) - v) . m(T)] m(T),  m(T) = n(S), S the neighbour at the "
              "weighted median of the angles between n(T) and n(S)",
          .parameters = with_iteration_parameters(
              {number_parameter("edge_weight", kDefaults.edge_weight, 0, 100, "1",
                                "Weight of a neighbour across an edge; one across a vertex weighs 1.")}),
          .work_memory = {.per_vertex = 130, .per_triangle = 55},
          .nanoseconds = 250,
          .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
            return smooth_median_normals(surface, {.edge_weight = values.number("edge_weight")},
                                         iteration_options(values, surface), run);
          }};
}

}  // namespace burnish
