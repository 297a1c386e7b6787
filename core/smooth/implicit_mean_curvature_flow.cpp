#include "core/smooth/implicit_mean_curvature_flow.h"

#include <algorithm>

#include "core/run/parallel.h"
#include "core/smooth/cotangent.h"
#include "core/smooth/parameters.h"

namespace burnish {
namespace {

class ImplicitFlow {
 public:
  ImplicitFlow(const Surface& surface, const ImplicitMeanCurvatureFlowParams& params,
               std::span<const std::uint8_t> movable, const RunControl& run)
      : surface_(surface),
        run_(run),
        time_step_(static_cast<float>(params.time_step)),
        largest_cotangent_(static_cast<float>(params.largest_cotangent)),
        mass_of_area_(static_cast<float>(1 / (3 * surface.mean_edge * surface.mean_edge))),
        faces_(surface.mesh.triangles.size()),
        system_(surface, movable, params.solver, run) {}

  bool prepare(std::span<const SimdVec3> from) {
    const bool measured = parallel_for(faces_.size(), run_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        faces_[f] = face_weights(surface_.mesh.triangles[f], from, largest_cotangent_);
      }
    });
    return measured &&
           system_.solve(from, [&](std::size_t v, std::span<float> weights) { return fill_row(v, weights); });
  }

  const SparseSystem& system() const { return system_; }

 private:
  /// dt (cot a + cot b)/2 per neighbour; returns the mass.
  float fill_row(std::size_t v, std::span<float> weights) const {
    const std::span<const Index> neighbours = surface_.topology.vertex_neighbours[v];
    const auto add = [&](Index neighbour, float half_cotangent) {
      std::size_t k = 0;
      while (neighbours[k] != neighbour) ++k;
      weights[k] += time_step_ * half_cotangent;
    };
    std::ranges::fill(weights, 0.0F);
    float area = 0;
    for (const Index f : surface_.topology.vertex_faces[v]) {
      const Triangle& t = surface_.mesh.triangles[f];
      const int c = corner_of(t, v), next = (c + 1) % 3, last = (c + 2) % 3;
      add(t[next], faces_[f].half_cotangent[last]);  // the angle opposite the edge
      add(t[last], faces_[f].half_cotangent[next]);
      area += faces_[f].area;
    }
    return std::max(kLeastMass, area * mass_of_area_);
  }

  const Surface& surface_;
  const RunControl& run_;
  float time_step_, largest_cotangent_, mass_of_area_;
  std::vector<FaceWeights> faces_;
  SparseSystem system_;
};

}  // namespace

Result<SmoothOutcome> smooth_implicit_mean_curvature_flow(Surface& surface,
                                                          const ImplicitMeanCurvatureFlowParams& params,
                                                          const IterationOptions& options,
                                                          const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  ImplicitFlow flow(surface, params, constraints.movable(), run);
  return iterate_system(surface, constraints, options, run, flow.system(),
                        [&](auto from) { return flow.prepare(from); });
}

Method implicit_mean_curvature_flow_method() {
  constexpr ImplicitMeanCurvatureFlowParams kDefaults;
  return {
      .name = "implicit_mean_curvature_flow",
      .summary =
          "Mean curvature flow in implicit time steps of any length, each a sparse linear system. It "
          "shrinks like its explicit twin; preserve_volume gives the volume back.",
      .reference =
          "M. Desbrun, M. Meyer, P. Schroeder, A. H. Barr, Implicit fairing of irregular meshes using "
          "diffusion and curvature flow, SIGGRAPH 1999, 317-324",
      .formula =
          "(M - dt L) X' = M X,  (L X)(v) = sum over neighbours w of (cot a + cot b)/2 (w - v),  M(v) = a "
          "third of the area at v",
      .parameters = with_solver_parameters(
          {number_parameter("time_step", kDefaults.time_step, 0, 1000, "squared mean edge lengths",
                            "Time per iteration; any step is stable."),
           number_parameter("largest_cotangent", kDefaults.largest_cotangent, 0.01, 1000, "1",
                            "Cotangents are clamped to [0, this]: without negative weights nothing "
                            "overshoots.")}),
      .work_memory = {.per_vertex = 400, .per_triangle = 45},
      .nanoseconds = 110,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_implicit_mean_curvature_flow(surface,
                                                   {.time_step = values.number("time_step"),
                                                    .largest_cotangent = values.number("largest_cotangent"),
                                                    .solver = solver_options(values)},
                                                   iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
