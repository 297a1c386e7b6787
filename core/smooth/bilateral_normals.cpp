#include "core/smooth/bilateral_normals.h"

#include <optional>

#include "core/smooth/bilateral_system.h"
#include "core/smooth/parameters.h"

namespace burnish {

Result<SmoothOutcome> smooth_bilateral_normals(Surface& surface, const BilateralNormalsParams& params,
                                               const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, params.neighbourhood, run);
  const BilateralWidths widths{.sigma_c = params.sigma_c, .sigma_s = params.sigma_s};
  std::optional<BilateralSystem> system;
  if (params.scheme == BilateralNormalsParams::Scheme::Global) system.emplace(faces);
  const auto filter = [&](std::span<const SimdVec3> from) {
    if (!faces.measure(from)) return false;
    if (system) return system->solve(faces, widths, params.lambda);
    for (std::uint32_t step = 0; step < params.normal_steps; ++step) {
      if (!filter_by_weights(faces, BilateralExponent(widths, faces, faces.normals()))) return false;
    }
    return true;
  };
  return iterate_normals(
      surface, faces, constraints, options,
      {.filter = filter, .move = move_to_fit(constraints, faces), .vertex_steps = params.vertex_steps});
}

Method bilateral_normals_method() {
  using P = BilateralNormalsParams;
  constexpr P kDefaults;
  return {
      .name = "bilateral_normals",
      .summary =
          "Averages face normals over neighbours that are near and turned alike and moves the vertices to "
          "fit; keeps edges and corners.",
      .reference =
          "Y. Zheng, H. Fu, O. K.-C. Au, C.-L. Tai, Bilateral normal filtering for mesh denoising, IEEE "
          "Transactions on Visualization and Computer Graphics 17 (2011) 1521-1530",
      .formula =
          "n'(i) = unit(sum over neighbours j of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_c^2) - |n(i) - n(j)|^2 "
          "/ (2 sigma_s^2)) n(j)), or all n' at once by least squares,  v' = v + mean over triangles f at v "
          "of "
          "[(c(f) - v) . n'(f)] n'(f)",
      .parameters = with_iteration_parameters({
          choice_parameter("scheme", {"local", "global"},
                           "Every normal from its neighbours, or all normals at once from a sparse system "
                           "over neighbours across edges."),
          number_parameter("sigma_s", kDefaults.sigma_s, 0.01, 10, "1",
                           "Standard deviation of the difference between unit normals: less keeps blunter "
                           "edges, and more of the noise."),
          centroid_distance_parameter("sigma_c", kDefaults.sigma_c),
          neighbourhood_parameter(kDefaults.neighbourhood),
          count_parameter("normal_steps", kDefaults.normal_steps, 1, 100,
                          "How often normals are filtered in a row; of the local scheme."),
          number_parameter(
              "lambda", kDefaults.lambda, 0.001, 1, "1",
              "Weight of the normals as they are against their smoothness; of the global scheme."),
          vertex_steps_parameter(kDefaults.vertex_steps),
      }),
      .work_memory = {.per_vertex = 100, .per_triangle = 190},
      .nanoseconds = 150,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        P params;
        if (values.choice("scheme") == "global") params.scheme = P::Scheme::Global;
        params.sigma_s = values.number("sigma_s");
        params.sigma_c = values.number("sigma_c");
        params.neighbourhood = neighbourhood_of(values);
        params.normal_steps = static_cast<std::uint32_t>(values.integer("normal_steps"));
        params.lambda = values.number("lambda");
        params.vertex_steps = static_cast<std::uint32_t>(values.integer("vertex_steps"));
        return smooth_bilateral_normals(surface, params, iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
