// The estimate of the noise: right on noise of known strength, whatever the shape, and the same however the
// mesh lies.
#include "core/measure/noise_estimate.h"

#include <gtest/gtest.h>

#include "core/shape/noise.h"
#include "tests/support/procedural.h"

namespace burnish {
namespace {

using namespace burnish::testing;
using Kind = NoiseEstimate::Kind;

NoiseEstimate estimate(const Surface& surface) { return estimate_noise(surface, surface.mesh.positions, {}); }

Surface noisy(const Surface& clean, const NoiseOptions& options) {
  Surface surface = clean;
  EXPECT_TRUE(add_noise(surface, options));
  return surface;
}

class NoiseOfShape : public ::testing::TestWithParam<std::string> {
 protected:
  const Surface clean_ = surface_of(procedural_shape(GetParam(), 1, 12'000).shape);
};

TEST_P(NoiseOfShape, IsNoneWhenItIsClean) {
  const NoiseEstimate found = estimate(clean_);
  EXPECT_EQ(found.kind, Kind::None);
  EXPECT_LT(found.sigma_over_edge, 0.03);
}

TEST_P(NoiseOfShape, IsFoundWithinAFifth) {
  for (const double sigma : {0.05, 0.1, 0.2, 0.4, 0.7}) {
    const NoiseEstimate found = estimate(noisy(clean_, {.amplitude = sigma}));
    EXPECT_EQ(found.kind, Kind::Gaussian) << sigma;
    EXPECT_NEAR(found.sigma_over_edge, sigma, 0.2 * sigma);
  }
}

TEST_P(NoiseOfShape, IsToldFromFewVerticesFarOff) {
  // Evenly from -a to a: a root mean square of a sqrt(fraction / 3).
  for (const auto& [amplitude, fraction] :
       {std::pair{1.0, 0.1}, {0.5, 0.1}, {1.0, 0.05}, {1.0, 0.2}, {1.0, 0.3}}) {
    const NoiseEstimate found =
        estimate(noisy(clean_, {.kind = NoiseKind::Impulsive, .amplitude = amplitude, .fraction = fraction}));
    const double sigma = amplitude * std::sqrt(fraction / 3);
    EXPECT_EQ(found.kind, Kind::Impulsive) << amplitude << " " << fraction;
    EXPECT_NEAR(found.sigma_over_edge, sigma, 0.2 * sigma) << amplitude << " " << fraction;
  }
}

INSTANTIATE_TEST_SUITE_P(Procedural, NoiseOfShape, ::testing::ValuesIn(procedural_names()),
                         [](const auto& row) { return row.param; });

TEST(NoiseEstimate, DoesNotDependOnHowTheMeshLiesOrHowManyThreadsLook) {
  const testing::Shape shape = with_noise(procedural_shape("vase", 1, 12'000).shape, 0.01);
  const NoiseEstimate found = estimate(surface_of(shape));
  EXPECT_GT(found.sigma_over_edge, 0.05);
  for (const testing::Shape& same : {scaled(shape, 1000), moved(shape, {5, -3, 8}), rotated(shape),
                                     with_vertex_order(shape, shuffled(shape.positions.size()))}) {
    EXPECT_NEAR(estimate(surface_of(same)).sigma_over_edge, found.sigma_over_edge, 1e-3);
  }
  const Surface surface = surface_of(shape);
  EXPECT_EQ(estimate_noise(surface, surface.mesh.positions, {.threads = 3}).sigma_over_edge,
            found.sigma_over_edge);
}

TEST(NoiseEstimate, IsNoneWhereThereIsTooLittleToSee) {
  EXPECT_EQ(estimate(surface_of(grid(1))).kind, Kind::None);
  EXPECT_EQ(estimate(surface_of(with_noise(cube(1), 0.1))).kind, Kind::None);
}

}  // namespace
}  // namespace burnish
