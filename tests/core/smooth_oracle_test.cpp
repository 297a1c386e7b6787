// Every method against its slow twin in tests/support/oracle.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/smooth/adaptive.h"
#include "core/smooth/laplacian.h"
#include "core/smooth/mean_curvature_flow.h"
#include "core/smooth/taubin.h"
#include "core/smooth/valence_order.h"
#include "tests/support/compared.h"
#include "tests/support/oracle.h"

namespace burnish {
namespace {

using namespace burnish::testing;

/// Float positions keep 2^-24 of the diagonal; a few dozen operations an iteration may each add that.
double tolerance(int iterations) { return 2e-6 * (1 + iterations); }

class Oracle : public ::testing::TestWithParam<int> {
 protected:
  static Shape after(const Shape& shape, const Smooth& smooth) {
    return smoothed(shape, smooth, {.iterations = static_cast<std::uint32_t>(GetParam())});
  }
};

TEST_P(Oracle, AgreesWithLaplacian) {
  for (const Shape& shape : various_shapes()) {
    const auto smooth = [](Surface& s, const IterationOptions& o) {
      return smooth_laplacian(s, {.lambda = 0.7}, o, {});
    };
    EXPECT_LT(deviation(shape, after(shape, smooth), oracle_laplacian(shape, 0.7, GetParam())),
              tolerance(GetParam()));
  }
}

TEST_P(Oracle, AgreesWithTaubin) {
  for (const Shape& shape : various_shapes()) {
    const auto smooth = [](Surface& s, const IterationOptions& o) { return smooth_taubin(s, {}, o, {}); };
    EXPECT_LT(deviation(shape, after(shape, smooth), oracle_taubin(shape, 0.5, -0.53, GetParam())),
              tolerance(GetParam()));
  }
}

TEST_P(Oracle, AgreesWithMeanCurvatureFlow) {
  for (const Shape& shape : various_shapes()) {
    const MeanCurvatureFlowParams params;
    const auto smooth = [&](Surface& s, const IterationOptions& o) {
      return smooth_mean_curvature_flow(s, params, o, {});
    };
    EXPECT_LT(deviation(shape, after(shape, smooth), oracle_mean_curvature_flow(shape, params, GetParam())),
              10 * tolerance(GetParam()));  // cotangents of slivers amplify rounding
  }
}

TEST_P(Oracle, AgreesWithAdaptiveInEveryVariant) {
  using P = AdaptiveParams;
  for (const Shape& shape : various_shapes()) {
    for (const P& params : {
             P{},
             P{.normals = P::Normals::Unit},
             P{.neighbourhood = P::Neighbourhood::Vertices},
             P{.offsets = P::Offsets::Area},
             P{.umbrella = P::Umbrella::InverseLength},
             P{.coefficient = P::Coefficient::Linear},
             P{.coefficient = P::Coefficient::Gaussian, .sigma = 0.3},
             P{.scale = 0.5},
         }) {
      const auto smooth = [&](Surface& s, const IterationOptions& o) {
        return smooth_adaptive(s, params, o, {});
      };
      EXPECT_LT(deviation(shape, after(shape, smooth), oracle_adaptive(shape, params, GetParam())),
                10 * tolerance(GetParam()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Iterations, Oracle, ::testing::Values(1, 20));

/// Two pyramids with their bases together: apexes of this valence.
Shape double_pyramid(Index valence) {
  Shape shape{{{0, 0, 1}, {0, 0, -1}}, {}};
  for (Index i = 0; i < valence; ++i) {
    const double angle = 2 * std::numbers::pi * i / valence;
    shape.positions.push_back({std::cos(angle), std::sin(angle), 0});
    const Index a = 2 + i, b = 2 + (i + 1) % valence;
    shape.triangles.push_back({0, a, b});
    shape.triangles.push_back({1, b, a});
  }
  return with_noise(shape, 0.1);
}

TEST(Oracle, AgreesWithAdaptiveAtAnyValenceHoweverTrianglesAreTurned) {
  const auto adaptive = [](Surface& s, const IterationOptions& o) { return smooth_adaptive(s, {}, o, {}); };
  for (Index valence = 3; valence <= 14; ++valence) {
    const Shape shape = double_pyramid(valence);
    Shape turned = shape, open = shape;
    for (std::size_t t = 0; t < turned.triangles.size(); t += 3)
      std::swap(turned.triangles[t][0], turned.triangles[t][1]);
    open.triangles.pop_back();  // beyond which nothing lies
    const Shape expected = oracle_adaptive(shape, {}, 3);
    EXPECT_GT(deviation(shape, shape, expected), 0.01) << valence;
    EXPECT_LT(deviation(shape, smoothed(shape, adaptive, {.iterations = 3}), expected), 1e-5) << valence;
    EXPECT_LT(deviation(shape, smoothed(turned, adaptive, {.iterations = 3}), expected), 1e-5) << valence;
    EXPECT_LT(deviation(open, smoothed(open, adaptive, {.iterations = 3}), oracle_adaptive(open, {}, 3)),
              1e-5)
        << valence;
  }
}

/// What is fetched ahead lies beyond the end of the last blocks.
TEST(Oracle, AgreesWithWhatIsFetchedAheadOnLargeMeshes) {
  constexpr double kTolerance = 2e-4;  // a diagonal of 730 edges
  const Shape shape = with_noise(grid(515), 0.1);
  ASSERT_TRUE(pays_to_fetch_ahead(shape.positions.size()));
  const auto laplacian = [](Surface& s, const IterationOptions& o) { return smooth_laplacian(s, {}, o, {}); };
  const auto adaptive = [](Surface& s, const IterationOptions& o) { return smooth_adaptive(s, {}, o, {}); };
  EXPECT_LT(deviation(shape, smoothed(shape, laplacian, {.iterations = 1}), oracle_laplacian(shape, 0.5, 1)),
            kTolerance);
  EXPECT_LT(deviation(shape, smoothed(shape, adaptive, {.iterations = 1}), oracle_adaptive(shape, {}, 1)),
            kTolerance);
}

TEST(Adaptive, CoefficientGrowsAndIsBounded) {
  using P = AdaptiveParams;
  struct Row {
    P params;
    double at_zero, most;
  };
  for (const Row& row : {Row{{}, 1, 1.5}, Row{{.coefficient = P::Coefficient::Linear}, 0, 1},
                         Row{{.coefficient = P::Coefficient::Gaussian}, 0, 1}}) {
    EXPECT_EQ(offset_coefficient(row.params, 0), row.at_zero);
    EXPECT_EQ(offset_coefficient(row.params, 1e300), row.most);
    double last = row.at_zero;
    for (double x = 0; x < 2; x += 0.001) {
      EXPECT_GE(offset_coefficient(row.params, x), last);
      last = offset_coefficient(row.params, x);
    }
  }
  EXPECT_DOUBLE_EQ(offset_coefficient({}, 0.25), std::exp(0.25));
}

TEST(Adaptive, CoefficientVariesOverANoisyMesh) {
  // Where d were 1 everywhere nothing would be adaptive: the linear coefficient must move rough places more.
  Shape shape = with_noise(sphere(3), 0.002);
  shape.positions[0] *= 1.1;
  Surface surface = surface_of(shape);
  const auto before = surface.mesh.positions;
  ASSERT_TRUE(
      smooth_adaptive(surface, {.coefficient = AdaptiveParams::Coefficient::Linear}, {.iterations = 1}, {}));
  const double spike = length(surface.mesh.positions[0] - before[0]);
  const double calm = length(surface.mesh.positions[200] - before[200]);
  EXPECT_GT(spike, 50 * calm);
  EXPECT_GT(calm, 0);
}

TEST(MeanCurvatureFlow, ShrinksASphereByItsClosedForm) {
  Surface surface = surface_of(sphere(4));
  const double h = surface.mean_edge * surface.mesh.frame.scale();
  ASSERT_TRUE(smooth_mean_curvature_flow(surface, {}, {.iterations = 200}, {}));
  const double t = 200 * 0.025 * h * h;
  const double expected = std::sqrt(1 - 4 * t);  // r^2 = r0^2 - 4t
  ASSERT_LT(expected, 0.99);
  for (const Vec3f& p : surface.mesh.positions) {
    EXPECT_NEAR(length(surface.mesh.frame.to_file(to_double(p))), expected, 0.01 * (1 - expected) + 2e-3);
  }
}

}  // namespace
}  // namespace burnish
