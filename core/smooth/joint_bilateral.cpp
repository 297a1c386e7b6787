#include "core/smooth/joint_bilateral.h"

#include "core/smooth/bilateral_filter.h"
#include "core/smooth/parameters.h"

namespace burnish {
namespace {

/// The caller's constraints, and the method's bound on the distance to the input.
Constraints bounded(const Surface& surface, ConstraintOptions options, double distance,
                    const RunControl& run) {
  const double bound = distance * surface.mean_edge;
  if (options.max_displacement == 0 || options.max_displacement > bound) options.max_displacement = bound;
  return {surface, options, run};
}

}  // namespace

Result<SmoothOutcome> smooth_joint_bilateral(Surface& surface, const JointBilateralParams& params,
                                             const IterationOptions& options, const RunControl& run) {
  const Constraints constraints = bounded(surface, options.constraints, params.distance, run);
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  Buffer<SimdVec3> guide(faces.size());
  const auto filter = [&](std::span<const SimdVec3> from) {
    if (!faces.measure(from) || !faces.copy_normals(guide)) return false;
    for (std::uint32_t step = 0; step < params.guide_steps; ++step) {
      if (!faces.filter([&](std::size_t f) { return faces.mean_of_neighbours(f); })) return false;
    }
    faces.swap_normals(guide);
    return filter_by_weights(faces, BilateralExponent({params.sigma_c, params.sigma_s}, faces, guide));
  };
  const float laplacian = static_cast<float>(params.laplacian);
  return iterate_normals(surface, faces, constraints, options,
                         {.filter = filter,
                          .move = move_by(constraints,
                                          [&](auto from, std::size_t v) {
                                            return faces.offset_by_count(from[v], v) +
                                                   faces.tangential_umbrella(from, v) * laplacian;
                                          }),
                          .vertex_steps = params.vertex_steps});
}

Method joint_bilateral_method() {
  constexpr JointBilateralParams kDefaults;
  return {
      .name = "joint_bilateral",
      .summary =
          "Filters face normals by weights from a smoothed copy of them, moves the vertices to fit, and "
          "keeps "
          "them near the input; for much noise.",
      .reference =
          "After M. Wei et al. 2013, feature-preserving optimization for noisy meshes by joint bilateral "
          "filter and constrained Laplacian smoothing; guide, step and constraints are ours",
      .formula =
          "n'(i) = unit(sum over neighbours j of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_c^2) - |g(i) - g(j)|^2 "
          "/ (2 sigma_s^2)) n(j)),  g = smoothed normals,  v' = v + mean over triangles f at v of [(c(f) - "
          "v) "
          ". n'(f)] n'(f) + laplacian (U - (U . n) n),  |v' - input| <= distance h",
      .parameters = with_iteration_parameters({
          number_parameter("sigma_s", kDefaults.sigma_s, 0.01, 10, "1",
                           "Standard deviation of the difference between unit normals of the guide."),
          centroid_distance_parameter("sigma_c", kDefaults.sigma_c),
          count_parameter(
              "guide_steps", kDefaults.guide_steps, 1, 100,
              "How often normals are averaged over the triangles that share a vertex, to make the "
              "guide."),
          number_parameter("laplacian", kDefaults.laplacian, 0, 1, "1",
                           "Part of the way to the mean of the neighbours, within the surface."),
          vertex_steps_parameter(kDefaults.vertex_steps),
          number_parameter("distance", kDefaults.distance, 0.001, 1000, "mean edge lengths",
                           "No vertex ends farther than this from where it came."),
      }),
      .work_memory = {.per_vertex = 145, .per_triangle = 70},
      .nanoseconds = 220,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_joint_bilateral(
            surface,
            {.sigma_s = values.number("sigma_s"),
             .sigma_c = values.number("sigma_c"),
             .guide_steps = static_cast<std::uint32_t>(values.integer("guide_steps")),
             .laplacian = values.number("laplacian"),
             .vertex_steps = static_cast<std::uint32_t>(values.integer("vertex_steps")),
             .distance = values.number("distance")},
            iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
