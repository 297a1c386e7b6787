#include "core/smooth/auto.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/denoise/surface_class.h"
#include "core/measure/noise_estimate.h"
#include "core/smooth/learned_normals.h"
#include "core/smooth/parameters.h"

namespace burnish {
namespace {

/// Noise in mean edge lengths up to which a mesh is as good as clean, and from which on all of it goes.
constexpr double kClean = 0.03, kNoisy = 0.045;

/// How much of what the networks would take away is noise: from 0 to 1, in hundredths, so that it can be
/// written down. Impulses are told from the surface one by one, however weak they are together.
double share_of_noise(const NoiseEstimate& noise) {
  if (noise.kind == NoiseEstimate::Kind::Impulsive) return 1;
  const double x = std::clamp((noise.sigma_over_edge - kClean) / (kNoisy - kClean), 0.0, 1.0);
  return std::round(100 * x * x * (3 - 2 * x)) / 100;
}

const char* kind_of_surface(double sharp_bending) {
  return sharp_bending < 0.2   ? "free-form"
         : sharp_bending < 0.8 ? "free-form with sharp edges"
                               : "a machined part's";
}

std::string reason(const NoiseEstimate& noise, double share) {
  std::array<char, 200> text{};
  if (share == 0) {
    std::snprintf(text.data(), text.size(),
                  "the noise, %.3f mean edges, is no more than a clean mesh shows: nothing to take away",
                  noise.sigma_over_edge);
  } else {
    std::snprintf(text.data(), text.size(), "%s noise of %.3f mean edges%s",
                  std::string(name_of(noise.kind)).c_str(), noise.sigma_over_edge,
                  share < 1 ? ", near that of a clean mesh, so only part of the way" : "");
  }
  return text.data();
}

/// The end of the reason, once the surface is there.
std::string surface_below(double sharp_bending) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(),
                "; the surface below is %s: %.0f%% of its bending is at sharp edges",
                kind_of_surface(sharp_bending), 100 * sharp_bending);
  return text.data();
}

}  // namespace

Result<AutoPlan> plan_auto(const Surface& surface, const AutoParams& params, const IterationOptions& options,
                           const RunControl& run) {
  const NoiseEstimate noise = estimate_noise(surface, surface.mesh.positions, run);
  if (run.stopped()) return run.stop_error();
  const double share = share_of_noise(noise), strength = params.strength * share;
  const std::int64_t stages = strength == 0 ? 0 : options.iterations;
  MethodChoice choice{.method = "learned_normals",
                      .parameters = {{"iterations", stages}, {"strength", strength}},
                      .reason = reason(noise, share)};
  if (noise.kind == NoiseEstimate::Kind::Impulsive) choice.parameters["moves"] = "outliers";
  return AutoPlan{noise, std::move(choice)};
}

Result<SmoothOutcome> smooth_auto(Surface& surface, const AutoParams& params, const IterationOptions& options,
                                  const RunControl& run) {
  auto plan = plan_auto(surface, params, options, run);
  if (!plan) return plan.error();
  MethodChoice& choice = plan->choice;
  IterationOptions stages = options;
  stages.iterations = static_cast<std::uint32_t>(std::get<std::int64_t>(choice.parameters.at("iterations")));
  using Moves = LearnedNormalsParams::Moves;
  const LearnedNormalsParams chosen{
      .moves = choice.parameters.contains("moves") ? Moves::Outliers : Moves::All,
      .strength = std::get<double>(choice.parameters.at("strength"))};
  auto outcome = smooth_learned_normals(surface, chosen, stages, run);
  if (!outcome) return outcome.error();
  choice.sharp_bending = share_of_sharp_bending(surface, run);  // a stop makes it mean nothing
  if (share_of_noise(plan->noise) > 0) choice.reason += surface_below(choice.sharp_bending);
  outcome->noise = plan->noise;
  outcome->choice = std::move(choice);
  return outcome;
}

Method auto_method() {
  constexpr AutoParams kDefaults;
  return {
      .name = "auto",
      .summary =
          "Looks at the mesh and does what suits it: nothing to a clean one, and to a noisy one what "
          "learned_normals would, the more carefully the less noise there is; where few vertices are off, "
          "the others stay.",
      .reference = "see learned_normals",
      .formula =
          "strength' = strength s((sigma/h - 0.03) / 0.015),  s(x) = x^2 (3 - 2 x) for x within 0 to 1; "
          "strength' = strength for impulsive noise",
      .parameters = with_iteration_parameters(
          {number_parameter("strength", kDefaults.strength, 0, 2, "1",
                            "0 leaves the mesh as it is, 1 takes away what looks like noise, 2 more.")},
          kLearnedStages),
      .work_memory = learned_normals_method().work_memory,
      .nanoseconds = 2000,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_auto(surface, {.strength = values.number("strength")},
                           iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
