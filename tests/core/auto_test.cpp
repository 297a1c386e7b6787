// Smoothing without a parameter: better than what it got on every shape, and harmless where there is nothing
// to do.
#include "core/smooth/auto.h"

#include <gtest/gtest.h>

#include "core/denoise/normal_network.h"
#include "core/measure/error.h"
#include "core/measure/quality.h"
#include "core/shape/noise.h"
#include "core/smooth/learned_normals.h"
#include "tests/support/procedural.h"
#include "tests/support/refined.h"

namespace burnish {
namespace {

using namespace burnish::testing;
using Given = std::map<std::string, ParameterValue>;

SmoothOutcome run(Surface& surface, const char* name, const Given& given = {}) {
  const Method& method = **find_method(name);
  auto outcome = method.run(surface, *resolve_parameters(method, given), {});
  EXPECT_TRUE(outcome);
  return *outcome;
}

/// Seeds 11 and up were not trained on.
Surface shape_named(const std::string& name) { return surface_of(procedural_shape(name, 11, 12'000).shape); }

Surface noisy(const Surface& clean, double sigma, NoiseDirection direction = NoiseDirection::Normal) {
  Surface surface = clean;
  EXPECT_TRUE(add_noise(surface, {.direction = direction, .amplitude = sigma, .seed = 5}));
  return surface;
}

double ev(const Surface& surface, const Surface& clean) {
  return measure_errors(surface, surface.mesh.positions, clean, clean.mesh.positions, true, {})->ev_over_edge;
}

std::uint64_t flipped(const Surface& surface, const Surface& clean) {
  return *measure_errors(surface, surface.mesh.positions, clean, clean.mesh.positions, true, {})
              ->flipped_triangles;
}

double rms_displacement(const Surface& before, const Surface& after) {
  return measure_change(after, before.mesh.positions, after.mesh.positions, {})->rms_displacement /
         (before.mean_edge * before.mesh.frame.scale());
}

/// A tenth of the vertices off.
Surface with_impulses(const Surface& clean, double amplitude) {
  Surface surface = clean;
  EXPECT_TRUE(
      add_noise(surface, {.kind = NoiseKind::Impulsive, .amplitude = amplitude, .fraction = 0.1, .seed = 5}));
  return surface;
}

class AutoOnShape : public ::testing::TestWithParam<std::string> {};

TEST_P(AutoOnShape, TakesMostOfTheNoiseAway) {
  const Surface clean = shape_named(GetParam());
  for (const double sigma : {0.1, 0.3}) {
    Surface surface = noisy(clean, sigma);
    const double before = ev(surface, clean);
    const SmoothOutcome outcome = run(surface, "auto");
    EXPECT_LT(ev(surface, clean), 0.75 * before) << sigma;
    EXPECT_EQ(outcome.iterations, kLearnedStages);
  }
}

TEST_P(AutoOnShape, MakesNoImpulsesWorseHoweverWeak) {
  const Surface clean = shape_named(GetParam());
  for (const double amplitude : {0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0}) {
    Surface surface = with_impulses(clean, amplitude);
    const double before = ev(surface, clean);
    run(surface, "auto");
    EXPECT_LE(ev(surface, clean), before) << amplitude;
  }
}

TEST_P(AutoOnShape, LeavesACleanMeshAsItIs) {
  const Surface clean = shape_named(GetParam());
  Surface surface = clean;
  const SmoothOutcome outcome = run(surface, "auto");
  EXPECT_TRUE(surface.mesh.positions == clean.mesh.positions);
  EXPECT_EQ(outcome.iterations, 0U);
  EXPECT_NE(outcome.choice->reason.find("nothing to take away"), std::string::npos);
}

TEST_P(AutoOnShape, FindsNothingToDoASecondTime) {
  Surface once = noisy(shape_named(GetParam()), 0.2);
  run(once, "auto");
  Surface twice = once;
  run(twice, "auto");
  EXPECT_LT(rms_displacement(once, twice), 0.02);
}

TEST_P(AutoOnShape, UnfoldsTrianglesThatNoiseAlongTheSurfaceTurnedOver) {
  const Surface clean = shape_named(GetParam());
  Surface surface = noisy(clean, 0.3, NoiseDirection::Random);
  const auto before = flipped(surface, clean);
  run(surface, "auto");
  EXPECT_LT(flipped(surface, clean), before / 20);
}

INSTANTIATE_TEST_SUITE_P(Procedural, AutoOnShape, ::testing::ValuesIn(procedural_names()),
                         [](const auto& row) { return row.param; });

TEST(Auto, SaysWhatToAskForToGetTheSame) {
  const Surface shaft = shape_named("shaft");
  for (const Surface& start : {noisy(shaft, 0.04), noisy(shaft, 0.2), with_impulses(shaft, 0.5)}) {
    Surface chosen = start, asked = start;
    const SmoothOutcome outcome = run(chosen, "auto", {{"strength", 0.5}});
    ASSERT_TRUE(outcome.choice);
    EXPECT_EQ(outcome.choice->method, "learned_normals");
    const bool impulsive = outcome.noise->kind == NoiseEstimate::Kind::Impulsive;
    EXPECT_EQ(outcome.choice->parameters.contains("moves"), impulsive);
    EXPECT_NE(outcome.choice->reason.find(impulsive ? "impulsive noise" : "gaussian noise"),
              std::string::npos)
        << outcome.choice->reason;
    run(asked, outcome.choice->method.c_str(), outcome.choice->parameters);
    EXPECT_TRUE(chosen.mesh.positions == asked.mesh.positions);
    EXPECT_FALSE(chosen.mesh.positions == start.mesh.positions);
  }
}

TEST(Auto, SaysWhatKindOfSurfaceItFoundBelowTheNoise) {
  const auto said = [](const char* name) {
    Surface surface = noisy(shape_named(name), 0.2);
    return *run(surface, "auto").choice;
  };
  for (const char* machined : {"stairs", "bracket", "gear"}) {
    const MethodChoice choice = said(machined);
    EXPECT_GT(choice.sharp_bending, 0.8) << machined;
    EXPECT_NE(choice.reason.find("machined part"), std::string::npos) << choice.reason;
  }
  for (const char* figure : {"coarse_bumps", "blobs", "knot"}) {
    const MethodChoice choice = said(figure);
    EXPECT_LT(choice.sharp_bending, 0.2) << figure;
    EXPECT_NE(choice.reason.find("free-form:"), std::string::npos) << choice.reason;
  }
}

TEST(Auto, GoesFartherTheStrongerItIsAsked) {
  const Surface start = noisy(shape_named("coarse_bumps"), 0.2);
  double last = -1;
  for (const double strength : {0.0, 0.5, 1.0, 2.0}) {
    Surface surface = start;
    run(surface, "auto", {{"strength", strength}});
    const double moved = rms_displacement(start, surface);
    EXPECT_GT(moved, last) << strength;
    last = moved;
  }
  Surface untouched = start;
  run(untouched, "auto", {{"strength", 0.0}});
  EXPECT_TRUE(untouched.mesh.positions == start.mesh.positions);
}

TEST(Auto, LeavesMostVerticesAloneWhereFewAreOff) {
  double with_all = 0, with_outliers = 0;
  for (const char* name : {"shaft", "vase", "coarse_bumps", "fine_bumps"}) {
    const Surface clean = shape_named(name), start = with_impulses(clean, 0.6);
    Surface surface = start, all = start;
    run(surface, "auto");
    run(all, "learned_normals");
    std::size_t stayed = 0;
    for (std::size_t v = 0; v < start.mesh.positions.size(); ++v) {
      stayed += surface.mesh.positions[v] == start.mesh.positions[v] ? 1U : 0U;
    }
    EXPECT_GT(static_cast<double>(stayed), 0.7 * static_cast<double>(start.mesh.positions.size())) << name;
    EXPECT_LT(ev(surface, clean), 0.5 * ev(start, clean)) << name;
    with_all += ev(all, clean), with_outliers += ev(surface, clean);
  }
  EXPECT_LT(with_outliers, 0.8 * with_all);
}

TEST(Auto, MovesAllVerticesWhereAllAreOffThoughAskedForOutliers) {
  const Surface start = noisy(shape_named("shaft"), 0.3);
  Surface all = start, outliers = start;
  run(all, "learned_normals");
  run(outliers, "learned_normals", {{"moves", "outliers"}});
  EXPECT_TRUE(all.mesh.positions == outliers.mesh.positions);
}

/// With one measure of the noise for triangles of all sizes .1007, .1037 and .0747 were left.
TEST(Auto, KeepsWhatIsMadeOfLargeTrianglesBesideSmallOnes) {
  for (const auto& [name, most] : {std::pair{"vase", 0.09}, {"relief", 0.095}, {"cone", 0.068}}) {
    const Surface clean =
        surface_of(unevenly_refined(procedural_shape(name, 11, 2500).shape, Finest::BetweenCreases, 11));
    Surface surface = noisy(clean, 0.3);
    run(surface, "auto");
    EXPECT_LT(ev(surface, clean), most) << name;
  }
}

TEST(LearnedNormals, TurnNoTriangleAgainstWhatTheySee) {
  for (const char* name : {"gem", "fine_bumps", "gear"}) {
    const Surface clean = shape_named(name);
    Surface surface = noisy(clean, 0.3);
    const auto before = flipped(surface, clean);
    run(surface, "learned_normals");
    EXPECT_LE(flipped(surface, clean), before) << name;
  }
}

/// By the normals of the surface that the last steps made, 110 were.
TEST(LearnedNormals, TellTurnsByWhatTheyPredicted) {
  std::uint64_t turned = 0;
  for (const char* name : {"gem", "stairs", "bracket", "relief", "gear", "hair"}) {
    const Surface clean = shape_named(name);
    Surface surface = noisy(clean, 0.6);
    run(surface, "learned_normals");
    turned += flipped(surface, clean);
  }
  EXPECT_LT(turned, 95U);
}

TEST(NormalNetworks, AreOnePerStage) { EXPECT_EQ(normal_networks().size(), kLearnedStages); }

}  // namespace
}  // namespace burnish
