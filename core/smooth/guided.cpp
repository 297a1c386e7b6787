#include "core/smooth/guided.h"

#include <optional>

#include "core/smooth/parameters.h"

namespace burnish {

Result<SmoothOutcome> smooth_guided(Surface& surface, const GuidedParams& params,
                                    const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  std::optional<GuidedFilter> guided;
  const auto filter = [&](std::span<const SimdVec3> from) {
    bool going = faces.measure(from);
    if (!guided) guided.emplace(faces, params.radius);
    for (std::uint32_t step = 0; going && step < params.normal_steps; ++step) {
      going = guided->filter(faces, {.sigma_s = params.sigma_s, .sigma_r = params.sigma_r});
    }
    return going;
  };
  return iterate_normals(
      surface, faces, constraints, options,
      {.filter = filter, .move = move_to_fit(constraints, faces), .vertex_steps = params.vertex_steps});
}

Method guided_method() {
  constexpr GuidedParams kDefaults;
  return {
      .name = "guided",
      .summary =
          "Averages face normals over neighbours whose surroundings, where they are most even, are turned "
          "alike, and moves the vertices to fit; keeps sharp edges under much noise.",
      .reference =
          "W. Zhang, B. Deng, J. Zhang, S. Bouaziz, L. Liu, Guided mesh normal filtering, Computer Graphics "
          "Forum 34 (2015) 23-34",
      .formula =
          "n'(i) = unit(sum over neighbours j of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_s^2) - |g(i) - g(j)|^2 "
          "/ (2 sigma_r^2)) n(j)),  g(i) = mean normal of the patch around i with the least Phi R, Phi = "
          "largest difference of its normals, R = largest over summed differences across its edges,  v' = v "
          "+ mean over triangles f at v of [(c(f) - v) . n'(f)] n'(f)",
      .parameters = with_iteration_parameters({
          number_parameter("sigma_r", kDefaults.sigma_r, 0.01, 10, "1",
                           "Standard deviation of the difference between guidance normals: less keeps "
                           "blunter edges, and more of the noise."),
          centroid_distance_parameter("sigma_s", kDefaults.sigma_s),
          number_parameter("radius", kDefaults.radius, 0, 4, "mean distances of adjacent centroids",
                           "Neighbours are the triangles whose centroids are this near, and all that share "
                           "a vertex; 128 at most."),
          count_parameter("normal_steps", kDefaults.normal_steps, 1, 100,
                          "How often normals are filtered in a row."),
          vertex_steps_parameter(kDefaults.vertex_steps),
      }),
      .work_memory = {.per_vertex = 180, .per_triangle = 360},
      .nanoseconds = 290,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_guided(surface,
                             {.sigma_r = values.number("sigma_r"),
                              .sigma_s = values.number("sigma_s"),
                              .radius = values.number("radius"),
                              .normal_steps = static_cast<std::uint32_t>(values.integer("normal_steps")),
                              .vertex_steps = static_cast<std::uint32_t>(values.integer("vertex_steps"))},
                             iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
