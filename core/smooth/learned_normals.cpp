#include "core/smooth/learned_normals.h"

#include <optional>

#include "core/denoise/normal_cascade.h"
#include "core/smooth/parameters.h"

namespace burnish {
Result<SmoothOutcome> smooth_learned_normals(Surface& surface, const LearnedNormalsParams& params,
                                             const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const CascadeOptions cascade_options{
      .vertex_steps = params.vertex_steps,
      .give_back = params.give_back,
      .give_back_flat = params.give_back_flat,
      .facet_steps = params.facet_steps,
      .plane_steps = params.plane_steps,
      .only_outliers = params.moves == LearnedNormalsParams::Moves::Outliers};
  const float strength = static_cast<float>(params.strength);
  std::optional<NormalCascade> cascade;  // takes memory that no stage at all does not need
  if (options.iterations > 0) {
    cascade.emplace(surface, constraints.movable(), cascade_options, normal_networks(), run);
  }
  std::uint32_t stage = 0;
  const auto advance = [&](std::span<const SimdVec3> from) {
    if (!cascade->advance(from)) return false;
    if (++stage < options.iterations) return true;
    return cascade->finish() && (strength >= 1 || cascade->stay_behind(strength)) &&
           (strength <= 1 || cascade->go_beyond(strength - 1));
  };
  const auto move = [&](auto, auto to, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (cascade->movable(v)) to[v] = cascade->positions()[v];
    }
  };
  // After all that a caller asked for, so that none of it turns a triangle either.
  const auto unflip = [&](std::span<SimdVec3> positions) { return !cascade || cascade->unflip(positions); };
  return iterate(surface, constraints, options, run, {.prepare = advance, .move = move, .finish = unflip});
}

Method learned_normals_method() {
  using P = LearnedNormalsParams;
  constexpr P kDefaults;
  return {
      .name = "learned_normals",
      .summary =
          "Face normals predicted by small networks, trained on shapes with artificial noise, from a dozen "
          "filtered ones; vertices move to fit. Needs no parameter: it tells noise from edges and folds by "
          "itself.",
      .reference =
          "after P.-S. Wang, Y. Liu, X. Tong, Mesh denoising via cascaded normal regression, ACM "
          "Transactions on Graphics 35 (2016) 232; networks and inputs are ours",
      .formula =
          "n'(f) = unit(sum over fields k of w_k n_k(f)),  w = C r(B r(A x + a) + b) + c,  r(x) = max(x, x / "
          "10),  x the differences |n_j(f) - n_k(f)| and the offsets of centroids;  v' = v + mean over "
          "triangles f at v of [(c(f) - v) . n'(f)] n'(f)",
      .parameters = with_iteration_parameters(
          {
              count_parameter("vertex_steps", kDefaults.vertex_steps, 1, 1000,
                              "How often the vertices move per stage."),
              count_parameter(
                  "give_back", kDefaults.give_back, 0, 100,
                  "Rings over which what the steps took away is averaged and given back, so that "
                  "the surface stays where the scan has it; of surfaces that are curved all over."),
              count_parameter(
                  "give_back_flat", kDefaults.give_back_flat, 0, 100,
                  "The same of surfaces that are mostly flat; between the two by the share of edges "
                  "that do not bend. 0 and 0 give nothing back."),
              count_parameter("facet_steps", kDefaults.facet_steps, 0, 100,
                              "How often, after the last stage, normals are filtered bilaterally where the "
                              "surface is flat between sharp edges."),
              count_parameter("plane_steps", kDefaults.plane_steps, 0, 100,
                              "How often, after that, vertices move onto the planes that the surface is made "
                              "of, and their edges; 0: it need not have planes."),
              choice_parameter("moves", {"all", "outliers"},
                               "Whether all vertices move, or only those that stand out from their "
                               "neighbours, as impulsive noise leaves them."),
              number_parameter("strength", kDefaults.strength, 0, 2, "1",
                               "Share of the way to go; above 1, on towards a surface that is smoother than "
                               "learned."),
          },
          kLearnedStages),
      .work_memory = {.per_vertex = 96, .per_triangle = 60, .per_triangle_of_part = 456},
      .nanoseconds = 1800,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        P params;
        params.vertex_steps = static_cast<std::uint32_t>(values.integer("vertex_steps"));
        params.give_back = static_cast<std::uint32_t>(values.integer("give_back"));
        params.give_back_flat = static_cast<std::uint32_t>(values.integer("give_back_flat"));
        params.facet_steps = static_cast<std::uint32_t>(values.integer("facet_steps"));
        params.plane_steps = static_cast<std::uint32_t>(values.integer("plane_steps"));
        if (values.choice("moves") == "outliers") params.moves = P::Moves::Outliers;
        params.strength = values.number("strength");
        return smooth_learned_normals(surface, params, iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
