#include "core/smooth/taubin.h"

#include "core/run/parallel.h"
#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"

namespace burnish {

Result<SmoothOutcome> smooth_taubin(Surface& surface, const TaubinParams& params,
                                    const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const UmbrellaStep step(surface, constraints.movable(), run);
  const float lambda = static_cast<float>(params.lambda), mu = static_cast<float>(params.mu);
  std::vector<SimdVec3> shrunk(surface.mesh.positions.begin(), surface.mesh.positions.end());
  return iterate(
      surface, constraints, options, run,
      {.prepare =
           [&](auto from) {
             return parallel_for(from.size(), run,
                                 [&](std::size_t begin, std::size_t) { step(lambda, from, shrunk, begin); });
           },
       .move = [&](auto, auto to, std::size_t begin, std::size_t) { step(mu, shrunk, to, begin); }});
}

Method taubin_method() {
  constexpr TaubinParams kDefaults;
  return {
      .name = "taubin",
      .summary =
          "A shrinking and a growing Laplacian step per iteration: a low-pass filter that nearly keeps "
          "volume.",
      .reference = "G. Taubin, A signal processing approach to fair surface design, SIGGRAPH 1995, 351-358",
      .formula = "v' = v + lambda U(v),  then  v'' = v' + mu U(v');  pass band kPB = 1/lambda + 1/mu",
      .parameters = with_iteration_parameters(
          {number_parameter("lambda", kDefaults.lambda, 0, 1, "1", "Shrinking step."),
           number_parameter("mu", kDefaults.mu, -1.1, 0, "1",
                            "Growing step; a little larger in size than lambda.")}),
      .work_memory = {.per_vertex = 140, .per_triangle = 15},
      .nanoseconds = 3,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_taubin(surface, {.lambda = values.number("lambda"), .mu = values.number("mu")},
                             iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
