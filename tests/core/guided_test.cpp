// Guided and robust normal filtering: against their slow twins, and what they are for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/smooth/laplacian.h"
#include "tests/support/compared.h"
#include "tests/support/oracle_guided.h"

namespace burnish {
namespace {

using namespace burnish::testing;

Smooth guided(const GuidedParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_guided(s, p, o, {}); };
}
Smooth robust_normals(const RobustNormalsParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_robust_normals(s, p, o, {}); };
}
Smooth laplacian() {
  return [](Surface& s, const IterationOptions& o) { return smooth_laplacian(s, {}, o, {}); };
}

// ---- The twins ----

class GuidedOracle : public ::testing::TestWithParam<int> {
 protected:
  template <class Oracle>
  void expect_agreement(const Smooth& smooth, Oracle&& oracle) {
    for (const Shape& shape : rough_shapes()) {
      const Shape is = smoothed(shape, smooth, {.iterations = static_cast<std::uint32_t>(GetParam())});
      EXPECT_LT(deviation(shape, is, oracle(shape, GetParam())), 2e-5 * (1 + GetParam()))
          << shape.triangles.size();
    }
  }
};

TEST_P(GuidedOracle, AgreesWithGuided) {
  using P = GuidedParams;
  for (const P& p : {P{}, P{.sigma_r = 0.2, .sigma_s = 1.5, .radius = 3.5, .vertex_steps = 3},
                     P{.sigma_r = 0.6, .radius = 0, .normal_steps = 3, .vertex_steps = 1}}) {
    expect_agreement(guided(p), [&](auto& s, int n) { return oracle_guided(s, p, n); });
  }
}

TEST_P(GuidedOracle, AgreesWithRobustNormals) {
  using P = RobustNormalsParams;
  for (const P& p : {P{}, P{.first_threshold = 0.9,
                          .second_threshold = 0.4,
                          .sigma_c = 0.8,
                          .normal_steps = 1,
                          .vertex_steps = 4}}) {
    expect_agreement(robust_normals(p), [&](auto& s, int n) { return oracle_robust_normals(s, p, n); });
  }
}

INSTANTIATE_TEST_SUITE_P(Iterations, GuidedOracle, ::testing::Values(1, 20));

// ---- What they share ----

TEST(GuidedAndRobust, SmoothAcrossTrianglesThatWindTheOtherWay) {
  const Shape shape = with_noise(sphere(3), 0.02);
  Shape mixed = shape;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  for (const Smooth& smooth : {guided(), robust_normals()}) {
    const IterationOptions options{.iterations = 5};
    EXPECT_LT(largest_distance(smoothed(shape, smooth, options), smoothed(mixed, smooth, options)), 1e-4);
  }
}

TEST(GuidedAndRobust, KeepATiltedUnevenPlane) {
  Shape shape = with_noise(grid(12), 0.3, 7);
  for (Vec3d& p : shape.positions) p.z = 0.3 * p.x - 0.2 * p.y;
  for (const Smooth& smooth : {guided(), robust_normals()}) {
    for (const Vec3d& p : smoothed(shape, smooth).positions) EXPECT_NEAR(p.z, 0.3 * p.x - 0.2 * p.y, 2e-5);
  }
}

TEST(GuidedAndRobust, KeepTheEdgesOfANoisyCubeThatLaplacianRounds) {
  const Shape clean = cube(12), noisy = with_noise(clean, 0.04);
  const double rounded = edge_error(clean, smoothed(noisy, laplacian()));
  for (const Smooth& smooth : {guided(), robust_normals()}) {
    EXPECT_LT(edge_error(clean, smoothed(noisy, smooth)), 0.25 * rounded);
  }
}

// ---- What each is for ----

/// A cone of `sides` triangles: all share its tip.
Shape cone(int sides) {
  Shape shape;
  shape.positions.push_back({0, 0, 0.2});
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * M_PI * i / sides;
    shape.positions.push_back({std::cos(angle), std::sin(angle), 0});
    shape.triangles.push_back({0, static_cast<Index>(1 + i), static_cast<Index>(1 + (i + 1) % sides)});
  }
  return shape;
}

TEST(GuidedFilter, TakesNoMoreThanItsShareOfAVertexWithVeryManyTriangles) {
  const Surface surface = surface_of(cone(5000));
  const RunControl run;
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  const std::vector<SimdVec3> positions(surface.mesh.positions.begin(), surface.mesh.positions.end());
  ASSERT_TRUE(faces.measure(positions));
  const std::vector<SimdVec3> before(faces.normals().begin(), faces.normals().end());
  GuidedFilter filter(faces, 10);
  ASSERT_TRUE(filter.filter(faces, {}));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    EXPECT_NEAR(length(faces.normal(f)), 1, 1e-5);
    EXPECT_GT(dot(faces.normal(f), before[f]), 0.7F);
  }
}

TEST(GuidedFilter, GivesFlatSidesOneNormalEachAndNotAcrossTheirEdge) {
  const Shape clean = cube(8), noisy = with_noise(clean, 0.03);
  const Surface surface = surface_of(noisy);
  const RunControl run;
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  const std::vector<SimdVec3> positions(surface.mesh.positions.begin(), surface.mesh.positions.end());
  ASSERT_TRUE(faces.measure(positions));
  GuidedFilter filter(faces, 2);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(filter.filter(faces, {}));
  const auto is_corner = [&](Index v) {  // there, every patch reaches over an edge
    const Vec3d& p = clean.positions[v];
    return std::abs(p.x) == 1 && std::abs(p.y) == 1 && std::abs(p.z) == 1;
  };
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (std::ranges::any_of(clean.triangles[f], is_corner)) continue;
    const Vec3d side = cross(clean.positions[clean.triangles[f][1]] - clean.positions[clean.triangles[f][0]],
                             clean.positions[clean.triangles[f][2]] - clean.positions[clean.triangles[f][0]]);
    EXPECT_GT(dot(to_double(faces.normal(f).vec3()), side) / length(side), 0.98) << f;
  }
}

TEST(RobustNormals, KeepTheVolume) {
  const Shape shape = with_noise(sphere(2), 0.01);
  const Shape result = smoothed(shape, robust_normals(), {.iterations = 100});
  EXPECT_NEAR(volume(result) / volume(shape), 1, 3e-4);  // the same moves without correction: 0.9957
}

}  // namespace
}  // namespace burnish
