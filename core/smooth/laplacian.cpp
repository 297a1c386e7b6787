#include "core/smooth/laplacian.h"

#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"

namespace burnish {

Result<SmoothOutcome> smooth_laplacian(Surface& surface, const LaplacianParams& params,
                                       const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const float lambda = static_cast<float>(params.lambda);
  const UmbrellaStep step(surface, constraints.movable(), run);
  return iterate(
      surface, constraints, options, run,
      {.move = [&](auto from, auto to, std::size_t begin, std::size_t) { step(lambda, from, to, begin); }});
}

Method laplacian_method() {
  constexpr LaplacianParams kDefaults;
  return {
      .name = "laplacian",
      .summary = "Moves every vertex towards the mean of its neighbours; simple and fast, but it shrinks.",
      .reference =
          "D. A. Field, Laplacian smoothing and Delaunay triangulations, Communications in Applied "
          "Numerical Methods 4 (1988) 709-712",
      .formula = "v' = v + lambda U(v),  U(v) = mean of the neighbours of v, minus v",
      .parameters = with_iteration_parameters(
          {number_parameter("lambda", kDefaults.lambda, 0, 1, "1", "Part of the way per iteration.")}),
      .work_memory = {.per_vertex = 125, .per_triangle = 15},
      .nanoseconds = 2,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_laplacian(surface, {.lambda = values.number("lambda")},
                                iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
