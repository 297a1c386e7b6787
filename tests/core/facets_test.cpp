// Where surfaces are made of facets, and what smoothing these leaves alone.
#include "core/denoise/facets.h"

#include <gtest/gtest.h>

#include "core/measure/error.h"
#include "core/shape/noise.h"
#include "tests/support/procedural.h"

namespace burnish {
namespace {

using namespace burnish::testing;

Buffer<SimdVec3> positions_of(const Surface& surface) {
  Buffer<SimdVec3> positions;
  for (const Vec3f& p : surface.mesh.positions) positions.emplace_back(p);
  return positions;
}

/// Mean weight over the faces.
double weight(const Surface& surface) {
  const RunControl run;
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  const auto positions = positions_of(surface);
  std::vector<float> weights(faces.size());
  EXPECT_TRUE(faces.measure(positions) && weigh_facets(faces, positions, weights));
  double sum = 0;
  for (const float w : weights) {
    EXPECT_GE(w, 0);
    EXPECT_LE(w, 1);
    sum += static_cast<double>(w);
  }
  return sum / static_cast<double>(weights.size());
}

Surface shape_named(const std::string& name) { return surface_of(procedural_shape(name, 11, 8000).shape); }

TEST(WeighFacets, FindsMachinedPartsAndNeitherFreeFormsNorHair) {
  for (const char* machined : {"stairs", "star_prism", "bracket", "gem"}) {
    EXPECT_GT(weight(shape_named(machined)), 0.6) << machined;
  }
  for (const char* free : {"coarse_bumps", "fine_bumps", "blobs", "knot", "hair"}) {
    EXPECT_LT(weight(shape_named(free)), 0.1) << free;
  }
}

TEST(WeighFacets, OfAPlaneAndASphereAreNothing) {
  EXPECT_EQ(weight(surface_of(grid(20))), 0);  // nothing bends
  EXPECT_EQ(weight(surface_of(sphere(4))), 0);
}

class SmoothFacets : public ::testing::Test {
 protected:
  void smooth(const Surface& surface, std::uint32_t steps) {
    const RunControl run;
    Faces faces(surface, FaceNeighbourhood::Vertices, run);
    before_ = now_ = next_ = positions_of(surface);
    std::vector<std::uint8_t> movable;
    for (const std::uint8_t flags : surface.topology.vertex_flags) movable.push_back(flags == 0);
    EXPECT_TRUE(smooth_facets(faces, movable, steps, now_, next_));
  }
  double ev(const Surface& surface, const Buffer<SimdVec3>& positions, const Surface& clean) {
    std::vector<Vec3f> moved;
    for (const SimdVec3& p : positions) moved.push_back(p.vec3());
    return measure_errors(surface, moved, clean, clean.mesh.positions, true, {})->ev_over_edge;
  }
  bool moved(std::size_t v) const { return length(now_[v] - before_[v]) > 0; }

  Buffer<SimdVec3> before_, now_, next_;
};

TEST_F(SmoothFacets, TakesWeakNoiseOffThem) {
  for (const char* name : {"stairs", "star_prism", "gem"}) {
    const Surface clean = shape_named(name);
    Surface noisy = clean;
    ASSERT_TRUE(add_noise(noisy, {.amplitude = 0.03, .seed = 2}));
    smooth(noisy, 10);
    EXPECT_LT(ev(noisy, now_, clean), 0.7 * ev(noisy, before_, clean)) << name;
  }
}

/// What settles on planes next takes turns with the two.
TEST_F(SmoothFacets, LeavesTheResultInBothBuffers) {
  Surface noisy = shape_named("gem");
  ASSERT_TRUE(add_noise(noisy, {.amplitude = 0.03, .seed = 2}));
  smooth(noisy, 10);
  for (std::size_t v = 0; v < now_.size(); ++v) EXPECT_TRUE(now_[v].vec3() == next_[v].vec3()) << v;
}

TEST_F(SmoothFacets, LeavesFreeFormsToTheBit) {
  const Surface surface = shape_named("coarse_bumps");
  smooth(surface, 10);
  for (std::size_t v = 0; v < before_.size(); ++v) EXPECT_FALSE(moved(v)) << v;
}

TEST_F(SmoothFacets, MovesNothingInNoSteps) {
  const Surface surface = shape_named("gem");
  smooth(surface, 0);
  for (std::size_t v = 0; v < before_.size(); ++v) EXPECT_FALSE(moved(v)) << v;
}

}  // namespace
}  // namespace burnish
