#include "core/smooth/mean_normals.h"

#include "core/smooth/parameters.h"

namespace burnish {

Result<SmoothOutcome> smooth_mean_normals(Surface& surface, const MeanNormalsParams& params,
                                          const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, params.neighbourhood, run);
  const auto filter = [&](std::span<const SimdVec3> from) {
    return faces.measure(from) && faces.filter([&](std::size_t f) { return faces.mean_of_neighbours(f); });
  };
  return iterate_normals(surface, faces, constraints, options,
                         {.filter = filter, .move = move_by(constraints, [&](auto from, std::size_t v) {
                                              return faces.offset_by_area(from[v], v);
                                            })});
}

Method mean_normals_method() {
  return {
      .name = "mean_normals",
      .summary = "Replaces every face normal by the mean of its neighbours' and moves the vertices to fit.",
      .reference =
          "H. Yagou, Y. Ohtake, A. Belyaev, Mesh smoothing via mean and median filtering applied to face "
          "normals, Geometric Modeling and Processing 2002, 124-131",
      .formula =
          "v' = v + 1/sum A(T) sum A(T) [(c(T) - v) . m(T)] m(T),  m(T) = unit(sum over neighbours S of "
          "A(S) n(S))",
      .parameters = with_iteration_parameters({neighbourhood_parameter(MeanNormalsParams{}.neighbourhood)}),
      .work_memory = {.per_vertex = 130, .per_triangle = 55},
      .nanoseconds = 17,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_mean_normals(surface, {.neighbourhood = neighbourhood_of(values)},
                                   iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
