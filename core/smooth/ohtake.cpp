#include "core/smooth/ohtake.h"

#include "core/smooth/bilateral_filter.h"
#include "core/smooth/parameters.h"

namespace burnish {

Result<SmoothOutcome> smooth_ohtake(Surface& surface, const OhtakeParams& params,
                                    const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, params.neighbourhood, run);
  const float per_squared_bending = gaussian_factor(params.curvature / surface.mean_edge);
  const auto diffuse = [&] {
    return filter_by_weights(faces, [&](Index n, std::size_t f) {
      constexpr float kNowhere = 1e-30F;  // squared distance of centroids that have run together
      const SimdVec3 way = faces.centroid(n) - faces.centroid(f), turn = faces.normal(n) - faces.normal(f);
      return per_squared_bending * dot(turn, turn) / std::max(dot(way, way), kNowhere);
    });
  };
  const float regularisation = static_cast<float>(params.regularisation);
  return iterate_normals(surface, faces, constraints, options,
                         {.filter = [&](auto from) { return faces.measure(from) && diffuse(); },
                          .move = move_by(constraints, [&](auto from, std::size_t v) {
                            return faces.offset_by_area(from[v], v) +
                                   faces.tangential_umbrella(from, v) * regularisation;
                          })});
}

Method ohtake_method() {
  constexpr OhtakeParams kDefaults;
  return {
      .name = "ohtake",
      .summary =
          "Diffuses face normals, less where the surface bends much, moves the vertices to fit, and evens "
          "out "
          "the triangles within the surface.",
      .reference =
          "Y. Ohtake, A. G. Belyaev, I. A. Bogaevski, Mesh regularization and adaptive smoothing, "
          "Computer-Aided Design 33 (2001) 789-800; the weights are ours",
      .formula =
          "v' = v + 1/sum A(T) sum A(T) [(c(T) - v) . m(T)] m(T) + regularisation (U - (U . n) n),  m(T) = "
          "unit(sum over neighbours S of A(S) exp(-k^2 / (2 curvature^2)) n(S)),  k = h |n(S) - n(T)| / "
          "|c(S) "
          "- c(T)|",
      .parameters = with_iteration_parameters({
          number_parameter("curvature", kDefaults.curvature, 0.1, 100, "radians per mean edge length",
                           "Bending from which on normals hardly diffuse: less keeps smaller features, and "
                           "more of the noise."),
          number_parameter("regularisation", kDefaults.regularisation, 0, 1, "1",
                           "Part of the way to the mean of the neighbours, within the surface."),
          neighbourhood_parameter(kDefaults.neighbourhood),
      }),
      .work_memory = {.per_vertex = 130, .per_triangle = 55},
      .nanoseconds = 140,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_ohtake(surface,
                             {.curvature = values.number("curvature"),
                              .regularisation = values.number("regularisation"),
                              .neighbourhood = neighbourhood_of(values)},
                             iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
