// The methods that solve sparse systems, and what solves them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/smooth/implicit_mean_curvature_flow.h"
#include "core/smooth/weighted_least_squares.h"
#include "tests/support/compared.h"
#include "tests/support/oracle_implicit.h"

namespace burnish {
namespace {

using namespace burnish::testing;
using Kind = SolverOptions::Kind;

Smooth flow(const ImplicitMeanCurvatureFlowParams& params, const RunControl& run = {}) {
  return [=](Surface& s, const IterationOptions& options) {
    return smooth_implicit_mean_curvature_flow(s, params, options, run);
  };
}
Smooth least_squares(const WeightedLeastSquaresParams& params) {
  return [=](Surface& s, const IterationOptions& options) {
    return smooth_weighted_least_squares(s, params, options, {});
  };
}

std::vector<std::string> codes(const SmoothOutcome& outcome) {
  std::vector<std::string> result;
  for (const Warning& warning : outcome.warnings) result.push_back(warning.code);
  return result;
}

/// The positions after one iteration.
std::vector<Vec3f> after_one(const Surface& start, const Smooth& smooth) {
  Surface surface = start;
  EXPECT_TRUE(smooth(surface, {.iterations = 1}));
  return surface.mesh.positions;
}

double largest_distance(std::span<const Vec3f> a, std::span<const Vec3f> b) {
  double worst = 0;
  for (std::size_t v = 0; v < a.size(); ++v) worst = std::max<double>(worst, length(a[v] - b[v]));
  return worst;
}

// ---- against the oracles

class ImplicitOracle : public ::testing::TestWithParam<int> {
 protected:
  /// Which warns of nothing.
  static Shape after(const Shape& shape, const Smooth& smooth) {
    Surface surface = surface_of(shape);
    const auto outcome = smooth(surface, {.iterations = static_cast<std::uint32_t>(GetParam())});
    EXPECT_TRUE(outcome && outcome->warnings.empty());
    return shape_on(surface, shape);
  }
  static double tolerance() { return 2e-5 * (1 + GetParam()); }
};

TEST_P(ImplicitOracle, AgreesWithTheFlowByEitherSolver) {
  for (const Shape& shape : various_shapes()) {
    for (const double time_step : {0.1, 3.0}) {
      for (const Kind kind : {Kind::ConjugateGradients, Kind::Cholesky}) {
        const ImplicitMeanCurvatureFlowParams params{.time_step = time_step,
                                                     .solver = {.kind = kind, .tolerance = 1e-6}};
        const Shape expected = oracle_implicit_mean_curvature_flow(shape, params, GetParam());
        EXPECT_LT(deviation(shape, after(shape, flow(params)), expected), tolerance()) << time_step;
      }
    }
  }
}

TEST_P(ImplicitOracle, AgreesWithWeightedLeastSquaresByEitherSolver) {
  for (const Shape& shape : various_shapes()) {
    for (const double sigma : {0.3, 2.0}) {
      for (const Kind kind : {Kind::ConjugateGradients, Kind::Cholesky}) {
        const WeightedLeastSquaresParams params{
            .lambda = 0.4, .sigma = sigma, .solver = {.kind = kind, .tolerance = 1e-6}};
        const Shape expected = oracle_weighted_least_squares(shape, params, GetParam());
        EXPECT_LT(deviation(shape, after(shape, least_squares(params)), expected), tolerance()) << sigma;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Iterations, ImplicitOracle, ::testing::Values(1, 20));

// ---- the flow's closed forms

/// Mean distance to the origin, in the file's unit.
double radius(const Surface& surface) {
  double sum = 0;
  for (const Vec3f& p : surface.mesh.positions) sum += length(surface.mesh.frame.to_file(to_double(p)));
  return sum / static_cast<double>(surface.mesh.positions.size());
}

double volume(const Surface& surface) {
  double sum = 0;
  const auto& p = surface.mesh.positions;
  for (const auto& [a, b, c] : surface.mesh.triangles) {
    sum += dot(to_double(p[a]), cross(to_double(p[b]), to_double(p[c]))) / 6;
  }
  return sum * std::pow(surface.mesh.frame.scale(), 3);
}

TEST(ImplicitFlow, ShrinksASphereByItsClosedForm) {
  Surface surface = surface_of(sphere(4));
  const double h = surface.mean_edge * surface.mesh.frame.scale(), start = volume(surface);
  ASSERT_TRUE(flow({.time_step = 0.5})(surface, {.iterations = 20}));
  const double expected = std::sqrt(1 - 4 * 20 * 0.5 * h * h);  // r^2 = r0^2 - 4t
  ASSERT_LT(expected, 0.9);
  EXPECT_NEAR(radius(surface), expected, 0.02 * (1 - expected));
  EXPECT_NEAR(volume(surface) / start, std::pow(expected, 3), 0.02);
}

TEST(ImplicitFlow, TakesALongStepAsTheEquationSays) {
  Surface surface = surface_of(sphere(4));
  const double h = surface.mean_edge * surface.mesh.frame.scale();
  ASSERT_TRUE(flow({.time_step = 200})(surface, {.iterations = 1}));
  const double expected = 1 / (1 + 2 * 200 * h * h);  // L X = -2/r^2 X on a sphere
  ASSERT_LT(expected, 0.5);
  EXPECT_NEAR(radius(surface), expected, 0.01);
}

TEST(ImplicitFlow, GoesOnWhenTheSurfaceHasShrunkToAPoint) {
  for (const Kind kind : {Kind::ConjugateGradients, Kind::Cholesky}) {
    Surface surface = surface_of(with_noise(sphere(2), 0.1));
    const auto outcome = flow({.time_step = 1000, .solver = {.kind = kind}})(surface, {.iterations = 100});
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->iterations, 100U);
    EXPECT_EQ(codes(*outcome), std::vector<std::string>{});
    EXPECT_LT(radius(surface), 0.1);
  }
}

TEST(ImplicitFlow, GivesTheVolumeBackWhenAsked) {
  Surface surface = surface_of(with_noise(sphere(3), 0.02));
  const double start = volume(surface);
  ASSERT_TRUE(flow({.time_step = 1})(surface, {.iterations = 3, .preserve_volume = true}));
  EXPECT_NEAR(volume(surface) / start, 1, 1e-5);
}

// ---- what both owe to the system they solve

TEST(SparseSystem, KeepsFixedVerticesToTheBitAndMovesTheOthers) {
  Surface start = surface_of(with_noise(grid(8), 0.2));
  start.pinned.assign(start.mesh.positions.size(), 0);
  start.pinned[40] = 1;
  ASSERT_FALSE(start.topology.has(40, kBoundaryVertex));
  for (const Kind kind : {Kind::ConjugateGradients, Kind::Cholesky}) {
    for (const Smooth& smooth :
         {flow({.solver = {.kind = kind}}), least_squares({.solver = {.kind = kind}})}) {
      const auto after = after_one(start, smooth);
      for (Index v = 0; v < after.size(); ++v) {
        const bool fixed = v == 40 || start.topology.has(v, kBoundaryVertex);
        EXPECT_EQ(after[v] == start.mesh.positions[v], fixed) << v;
      }
    }
  }
}

TEST(SparseSystem, HasNothingToDoWhereNothingMayMove) {
  const Surface start = surface_of(grid(1));
  for (const Kind kind : {Kind::Auto, Kind::ConjugateGradients, Kind::Cholesky}) {
    Surface surface = start;
    const auto outcome = flow({.time_step = 1000, .solver = {.kind = kind}})(surface, {.iterations = 2});
    ASSERT_TRUE(outcome);
    EXPECT_TRUE(outcome->warnings.empty());
    EXPECT_EQ(surface.mesh.positions, start.mesh.positions);
  }
}

TEST(SparseSystem, StaysInTheBoundingBoxForTheLongestSteps) {
  // Weights are not negative, so every vertex becomes a mean of old positions.
  for (const Shape& shape : {with_noise(sphere(3), 0.1), with_noise(grid(10), 0.9)}) {
    const Surface start = surface_of(shape);
    Vec3f low = start.mesh.positions[0], high = low;
    for (const Vec3f& p : start.mesh.positions) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    const float slack = 1e-3F * static_cast<float>(start.mean_edge);
    for (const Kind kind : {Kind::ConjugateGradients, Kind::Cholesky}) {
      for (const Smooth& smooth : {flow({.time_step = 1000, .solver = {.kind = kind}}),
                                   least_squares({.lambda = 1000, .sigma = 100, .solver = {.kind = kind}})}) {
        for (const Vec3f& p : after_one(start, smooth)) {
          for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_GE(p[axis], low[axis] - slack);
            EXPECT_LE(p[axis], high[axis] + slack);
          }
        }
      }
    }
  }
}

TEST(SparseSystem, SolversAgreeForAnyStep) {
  const Surface start = surface_of(with_noise(sphere(4), 0.02));
  for (const double time_step : {0.01, 1.0, 30.0, 1000.0}) {
    const auto one = after_one(start, flow({.time_step = time_step, .solver = {Kind::ConjugateGradients}}));
    const auto other = after_one(start, flow({.time_step = time_step, .solver = {Kind::Cholesky}}));
    EXPECT_LT(largest_distance(one, other), 3e-4 * start.mean_edge) << time_step;
  }
}

TEST(SparseSystem, AutoTakesGradientsForShortStepsAndCholeskyForLongOnes) {
  const Surface start = surface_of(with_noise(sphere(4), 0.02));
  const auto by = [&](Kind kind, double time_step) {
    return after_one(start, flow({.time_step = time_step, .solver = {.kind = kind}}));
  };
  EXPECT_EQ(by(Kind::Auto, 0.1), by(Kind::ConjugateGradients, 0.1));
  EXPECT_EQ(by(Kind::Auto, 1000), by(Kind::Cholesky, 1000));
  EXPECT_NE(by(Kind::Auto, 0.1), by(Kind::Cholesky, 0.1));
  EXPECT_NE(by(Kind::Auto, 1000), by(Kind::ConjugateGradients, 1000));
}

TEST(SparseSystem, ComesAsNearAsItsTolerance) {
  const Surface start = surface_of(with_noise(sphere(3), 0.05));
  const auto exact = after_one(start, flow({.time_step = 20, .solver = {Kind::Cholesky}}));
  double last = 0;
  for (const double tolerance : {1e-4, 1e-2, 0.1}) {
    const auto near =
        after_one(start, flow({.time_step = 20, .solver = {Kind::ConjugateGradients, tolerance}}));
    const double distance = largest_distance(near, exact);
    EXPECT_GT(distance, last);  // it does stop earlier
    EXPECT_LT(distance, tolerance * start.mean_edge);
    last = distance;
  }
}

TEST(SparseSystem, WarnsWhenGradientsReachTheirBoundAndFallsBackWhenItMay) {
  const Surface start = surface_of(with_noise(sphere(3), 0.05));
  for (const Kind kind : {Kind::ConjugateGradients, Kind::Auto}) {
    Surface surface = start;
    const auto outcome =
        flow({.time_step = 5, .solver = {.kind = kind, .most_iterations = 2}})(surface, {.iterations = 3});
    ASSERT_TRUE(outcome);
    const bool insists = kind == Kind::ConjugateGradients;
    EXPECT_EQ(codes(*outcome),
              insists ? std::vector<std::string>{"not_converged"} : std::vector<std::string>{});
    EXPECT_TRUE(!insists || outcome->warnings[0].count == 3);
  }
  EXPECT_EQ(after_one(start, flow({.time_step = 5, .solver = {.kind = Kind::Auto, .most_iterations = 2}})),
            after_one(start, flow({.time_step = 5, .solver = {.kind = Kind::Cholesky}})));
}

TEST(SparseSystem, TakesGradientsWhereCholeskyCouldNotAnswerAStop) {
  Surface surface = surface_of(sphere(6));
  ASSERT_GT(surface.mesh.positions.size(), kMostCholeskyVertices);
  const auto outcome = flow({.solver = {.kind = Kind::Cholesky}})(surface, {.iterations = 1});
  ASSERT_TRUE(outcome);
  EXPECT_EQ(codes(*outcome), std::vector<std::string>{"solver_changed"});
}

// ---- weighted least squares

TEST(WeightedLeastSquares, KeepsTheEdgesOfACubeThatTheFlowRounds) {
  // Vertices may drift within the sides, but not leave the cube's surface.
  const auto off_the_cube = [](const Smooth& smooth) {
    Surface surface = surface_of(cube(10));
    EXPECT_TRUE(smooth(surface, {.iterations = 5}));
    double worst = 0;
    for (const Vec3f& local : surface.mesh.positions) {
      const Vec3d p = surface.mesh.frame.to_file(to_double(local));
      worst = std::max(worst, std::abs(1 - std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)})));
    }
    return worst / (surface.mean_edge * surface.mesh.frame.scale());
  };
  EXPECT_LT(off_the_cube(least_squares({.sigma = 0.2})), 0.01);
  EXPECT_GT(off_the_cube(flow({})), 0.2);
}

TEST(WeightedLeastSquares, SmoothsAcrossTrianglesThatWindTheOtherWay) {
  const Shape shape = with_noise(sphere(3), 0.02);
  Shape mixed = shape;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  const Surface one = surface_of(shape), other = surface_of(mixed);
  EXPECT_LT(largest_distance(after_one(one, least_squares({})), after_one(other, least_squares({}))),
            1e-3 * one.mean_edge);
}

}  // namespace
}  // namespace burnish
