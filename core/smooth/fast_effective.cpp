#include "core/smooth/fast_effective.h"

#include <algorithm>

#include "core/smooth/parameters.h"

namespace burnish {
namespace {

SimdVec3 filtered_normal(const Faces& faces, std::size_t f, float threshold) {
  const SimdVec3 own = faces.normal(f);
  SimdVec3 sum;
  float weights = 0;
  faces.for_each_neighbour(f, [&](Index n) {
    const float above = std::max(dot(own, faces.normal(n)) - threshold, 0.0F);
    sum += faces.normal(n) * (above * above);
    weights += above * above;
  });
  return unit_or(sum, weights, own);
}

}  // namespace

Result<SmoothOutcome> smooth_fast_effective(Surface& surface, const FastEffectiveParams& params,
                                            const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, params.neighbourhood, run);
  const float threshold = static_cast<float>(params.threshold);
  bool filtered = false;
  const auto filter = [&](std::span<const SimdVec3> from) {
    if (filtered && params.filtering == FastEffectiveParams::Filtering::Once)
      return faces.measure_centroids(from);
    filtered = true;
    bool going = faces.measure(from);
    for (std::uint32_t step = 0; going && step < params.normal_steps; ++step) {
      going = faces.filter([&](std::size_t f) { return filtered_normal(faces, f, threshold); });
    }
    return going;
  };
  return iterate_normals(surface, faces, constraints, options,
                         {.filter = filter, .move = move_to_fit(constraints, faces)});
}

Method fast_effective_method() {
  using P = FastEffectiveParams;
  constexpr P kDefaults;
  return {
      .name = "fast_effective",
      .summary =
          "Averages face normals over neighbours whose normals differ little and moves the vertices to fit; "
          "keeps edges, for little or moderate noise.",
      .reference =
          "X. Sun, P. L. Rosin, R. R. Martin, F. C. Langbein, Fast and effective feature-preserving mesh "
          "denoising, IEEE Transactions on Visualization and Computer Graphics 13 (2007) 925-938",
      .formula =
          "n'(i) = unit(sum over neighbours j of max(n(i) . n(j) - T, 0)^2 n(j)),  v' = v + mean over "
          "triangles f at v of [(c(f) - v) . n'(f)] n'(f)",
      .parameters = with_iteration_parameters({
          choice_parameter("filtering", {"every_iteration", "once"},
                           "Whether normals are filtered before every step of the vertices, or once before "
                           "the first, as the authors do with 20 normal_steps."),
          count_parameter("normal_steps", kDefaults.normal_steps, 1, 100,
                          "How often normals are filtered in a row."),
          number_parameter("threshold", kDefaults.threshold, 0, 0.99, "1",
                           "T: cosine of the angle between normals from which on a neighbour does not count; "
                           "less for more noise."),
          neighbourhood_parameter(kDefaults.neighbourhood),
      }),
      .work_memory = {.per_vertex = 130, .per_triangle = 55},
      .nanoseconds = 130,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        P params;
        if (values.choice("filtering") == "once") params.filtering = P::Filtering::Once;
        params.normal_steps = static_cast<std::uint32_t>(values.integer("normal_steps"));
        params.threshold = values.number("threshold");
        params.neighbourhood = neighbourhood_of(values);
        return smooth_fast_effective(surface, params, iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
