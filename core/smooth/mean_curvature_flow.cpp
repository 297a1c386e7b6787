#include "core/smooth/mean_curvature_flow.h"

#include <algorithm>

#include "core/run/parallel.h"
#include "core/smooth/cotangent.h"
#include "core/smooth/parameters.h"

namespace burnish {
namespace {

SimdVec3 flow_step(const Surface& surface, std::span<const FaceWeights> weights,
                   std::span<const SimdVec3> from, std::size_t vertex, float time_step) {
  SimdVec3 pull;
  float total = 0, mass = 0;
  for (const Index f : surface.topology.vertex_faces[vertex]) {
    const Triangle& t = surface.mesh.triangles[f];
    const FaceWeights& w = weights[f];
    const int c = corner_of(t, vertex), next = (c + 1) % 3, last = (c + 2) % 3;
    // The edge to `next` is opposite the corner `last`, and the other way round.
    pull += (from[t[next]] - from[vertex]) * w.half_cotangent[last];
    pull += (from[t[last]] - from[vertex]) * w.half_cotangent[next];
    total += w.half_cotangent[last] + w.half_cotangent[next];
    mass += w.area;
  }
  if (!(total > 0)) return from[vertex];
  const float share = std::min(1.0F, 3.0F * time_step * total / mass);
  return from[vertex] + pull * (share / total);
}

}  // namespace

Result<SmoothOutcome> smooth_mean_curvature_flow(Surface& surface, const MeanCurvatureFlowParams& params,
                                                 const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const auto movable = constraints.movable();
  const float time_step = static_cast<float>(params.time_step * surface.mean_edge * surface.mean_edge);
  const float largest = static_cast<float>(params.largest_cotangent);
  std::vector<FaceWeights> weights(surface.mesh.triangles.size());
  return iterate(surface, constraints, options, run,
                 {.prepare =
                      [&](auto from) {
                        return parallel_for(weights.size(), run, [&](std::size_t begin, std::size_t end) {
                          for (std::size_t f = begin; f < end; ++f) {
                            weights[f] = face_weights(surface.mesh.triangles[f], from, largest);
                          }
                        });
                      },
                  .move =
                      [&](auto from, auto to, std::size_t begin, std::size_t end) {
                        for (std::size_t v = begin; v < end; ++v) {
                          if (movable[v]) to[v] = flow_step(surface, weights, from, v, time_step);
                        }
                      }});
}

Method mean_curvature_flow_method() {
  constexpr MeanCurvatureFlowParams kDefaults;
  return {.name = "mean_curvature_flow",
          .summary = "Moves every vertex along its mean curvature normal in explicit time steps.",
          .reference =
              "M. Desbrun, M. Meyer, P. Schroeder, A. H. Barr, Implicit fairing of irregular meshes using "
              "diffusion and curvature flow, SIGGRAPH 1999, 317-324",
          .formula =
              "v' = v + dt/M(v) sum over neighbours w of (cot a + cot b)/2 (w - v),  M(v) = a third of the "
              "area at v",
          .parameters = with_iteration_parameters(
              {number_parameter("time_step", kDefaults.time_step, 0, 10, "squared mean edge lengths",
                                "Time per iteration; a step that would overshoot is shortened."),
               number_parameter("largest_cotangent", kDefaults.largest_cotangent, 0.01, 1000, "1",
                                "Cotangents are clamped to [0, this]: slivers have huge ones and obtuse "
                                "triangles negative ones, and "
                                "both make the flow diverge on noise.")}),
          .work_memory = {.per_vertex = 130, .per_triangle = 15},
          .nanoseconds = 30,
          .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
            return smooth_mean_curvature_flow(surface,
                                              {.time_step = values.number("time_step"),
                                               .largest_cotangent = values.number("largest_cotangent")},
                                              iteration_options(values, surface), run);
          }};
}

}  // namespace burnish
