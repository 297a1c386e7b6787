#include "core/smooth/bilaplacian.h"

#include <cmath>

#include "core/run/parallel.h"
#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"

namespace burnish {
namespace {

/// Per vertex, 1 where U is not 0.
std::vector<std::uint8_t> bending(const Topology& topology, std::span<const std::uint8_t> movable) {
  std::vector<std::uint8_t> bends(movable.begin(), movable.end());
  for (Index v = 0; v < bends.size(); ++v) {
    if ((topology.vertex_flags[v] & (kBoundaryVertex | kIsolatedVertex)) == 0) bends[v] = 1;
  }
  return bends;
}

}  // namespace

Result<SmoothOutcome> smooth_bilaplacian(Surface& surface, const BilaplacianParams& params,
                                         const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const std::vector<std::uint8_t> bends = bending(surface.topology, constraints.movable());
  const UmbrellaStep first(surface, bends), second(surface, constraints.movable());
  const float root = static_cast<float>(std::sqrt(params.lambda));
  std::vector<SimdVec3> half(surface.mesh.positions.begin(), surface.mesh.positions.end());
  // v - lambda U(U(v)) is a step by root, then one by -root.
  return iterate(
      surface, constraints, options, run,
      {.prepare =
           [&](auto from) {
             return parallel_for(from.size(), run,
                                 [&](std::size_t begin, std::size_t) { first(root, from, half, begin); });
           },
       .move = [&](auto, auto to, std::size_t begin, std::size_t) { second(-root, half, to, begin); }});
}

Method bilaplacian_method() {
  constexpr BilaplacianParams kDefaults;
  return {.name = "bilaplacian",
          .summary =
              "Thin-plate smoothing by the squared umbrella operator: bends the surface as little as "
              "possible, and shrinks less than laplacian.",
          .reference =
              "L. Kobbelt, S. Campagna, J. Vorsatz, H.-P. Seidel, Interactive multi-resolution modeling on "
              "arbitrary meshes, SIGGRAPH 1998, 105-114",
          .formula = "v' = v - lambda U(U(v)),  U(v) = mean of the neighbours of v, minus v",
          .parameters = with_iteration_parameters({number_parameter(
              "lambda", kDefaults.lambda, 0, 0.5, "1",
              "Step; up to 0.25 no frequency changes its sign, beyond 0.5 the highest would grow.")}),
          .work_memory = {.per_vertex = 135, .per_triangle = 35},
          .nanoseconds = 4,
          .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
            return smooth_bilaplacian(surface, {.lambda = values.number("lambda")},
                                      iteration_options(values, surface), run);
          }};
}

}  // namespace burnish
