// The methods that filter face normals: against their slow twins, and what they are for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/measure/quality.h"
#include "core/smooth/laplacian.h"
#include "tests/support/compared.h"
#include "tests/support/oracle_normals.h"

namespace burnish {
namespace {

using namespace burnish::testing;

Smooth mean_normals(const MeanNormalsParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_mean_normals(s, p, o, {}); };
}
Smooth median_normals(const MedianNormalsParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_median_normals(s, p, o, {}); };
}
Smooth fast_effective(const FastEffectiveParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_fast_effective(s, p, o, {}); };
}
Smooth ohtake(const OhtakeParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_ohtake(s, p, o, {}); };
}
Smooth joint_bilateral(const JointBilateralParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_joint_bilateral(s, p, o, {}); };
}
Smooth bilateral_normals(const BilateralNormalsParams& p = {}) {
  return [=](Surface& s, const IterationOptions& o) { return smooth_bilateral_normals(s, p, o, {}); };
}
const BilateralNormalsParams kGlobal{.scheme = BilateralNormalsParams::Scheme::Global};
constexpr auto kEdges = FaceNeighbourhood::Edges, kVertices = FaceNeighbourhood::Vertices;

std::vector<Smooth> all_methods() {
  return {mean_normals(),
          mean_normals({.neighbourhood = kVertices}),
          median_normals(),
          fast_effective(),
          fast_effective({.filtering = FastEffectiveParams::Filtering::Once, .neighbourhood = kEdges}),
          ohtake(),
          joint_bilateral(),
          bilateral_normals(),
          bilateral_normals(kGlobal)};
}

// ---- The twins ----

class NormalOracle : public ::testing::TestWithParam<int> {
 protected:
  /// oracle(shape, iterations) against the method on each shape, in mean edge lengths.
  template <class Oracle>
  void expect_agreement(const Smooth& smooth, Oracle&& oracle, const std::vector<Shape>& shapes) {
    for (const Shape& shape : shapes) {
      const Shape is = smoothed(shape, smooth, {.iterations = static_cast<std::uint32_t>(GetParam())});
      EXPECT_LT(deviation(shape, is, oracle(shape, GetParam())), 2e-5 * (1 + GetParam()))
          << shape.triangles.size();
    }
  }

  const std::vector<Shape> tiny_ = {with_noise(sphere(1), 0.08), with_noise(grid(6), 0.15),
                                    with_noise(cube(3), 0.1)};
};

TEST_P(NormalOracle, AgreesWithMeanNormals) {
  for (const MeanNormalsParams& p : {MeanNormalsParams{}, {.neighbourhood = kVertices}}) {
    expect_agreement(
        mean_normals(p), [&](auto& s, int n) { return oracle_mean_normals(s, p, n); }, various_shapes());
  }
}

TEST_P(NormalOracle, AgreesWithMedianNormals) {
  for (const MedianNormalsParams& p : {MedianNormalsParams{}, {.edge_weight = 0.5}}) {
    expect_agreement(
        median_normals(p), [&](auto& s, int n) { return oracle_median_normals(s, p, n); }, various_shapes());
  }
}

TEST_P(NormalOracle, AgreesWithFastEffective) {
  using P = FastEffectiveParams;
  for (const P& p : {P{}, P{.threshold = 0.7, .neighbourhood = kEdges},
                     P{.filtering = P::Filtering::Once, .normal_steps = 5}}) {
    // On a coarse symmetric sphere rounding would decide between which triangles edges arise.
    expect_agreement(
        fast_effective(p), [&](auto& s, int n) { return oracle_fast_effective(s, p, n); }, rough_shapes());
  }
}

TEST_P(NormalOracle, AgreesWithOhtake) {
  using P = OhtakeParams;
  for (const P& p : {P{}, P{.curvature = 1.2, .regularisation = 0.3, .neighbourhood = kEdges}}) {
    expect_agreement(
        ohtake(p), [&](auto& s, int n) { return oracle_ohtake(s, p, n); }, various_shapes());
  }
}

TEST_P(NormalOracle, AgreesWithJointBilateral) {
  using P = JointBilateralParams;
  for (const P& p : {P{}, P{.sigma_s = 0.3, .sigma_c = 1, .guide_steps = 2, .vertex_steps = 3}}) {
    expect_agreement(
        joint_bilateral(p), [&](auto& s, int n) { return oracle_joint_bilateral(s, p, n); },
        various_shapes());
  }
}

TEST_P(NormalOracle, AgreesWithBilateralNormals) {
  using P = BilateralNormalsParams;
  for (const P& p :
       {P{},
        P{.sigma_s = 0.6, .sigma_c = 1, .neighbourhood = kEdges, .normal_steps = 3, .vertex_steps = 5}}) {
    expect_agreement(
        bilateral_normals(p), [&](auto& s, int n) { return oracle_bilateral_normals(s, p, n); },
        various_shapes());
  }
}

TEST_P(NormalOracle, AgreesWithTheDenseSolutionOfGlobalBilateralNormals) {
  BilateralNormalsParams other = kGlobal;
  other.lambda = 0.3;
  other.sigma_s = 0.25;
  for (const BilateralNormalsParams& p : {kGlobal, other}) {
    expect_agreement(
        bilateral_normals(p), [&](auto& s, int n) { return oracle_bilateral_normals(s, p, n); }, tiny_);
  }
}

INSTANTIATE_TEST_SUITE_P(Iterations, NormalOracle, ::testing::Values(1, 20));

// ---- What they share ----

TEST(Faces, NameEachNeighbourOnceAlsoAtNonManifoldEdges) {
  Shape shape = sphere(1);
  const auto [a, b, c] = shape.triangles[0];
  shape.positions.push_back({0, 0, 3});
  shape.triangles.push_back({a, b, static_cast<Index>(shape.positions.size() - 1)});  // a fin
  for (const Shape& s : {sphere(1), grid(4), shape}) {
    const Surface surface = surface_of(s);
    const auto& triangles = surface.mesh.triangles;
    const Faces faces(surface, kVertices, {});
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      std::multiset<Index> expected, named;
      for (Index g = 0; g < triangles.size(); ++g) {
        bool shares = false;
        for (const Index v : triangles[f]) shares |= std::ranges::count(triangles[g], v) > 0;
        if (shares && g != f) expected.insert(g);
      }
      faces.for_each_neighbour(f, [&](Index g) { named.insert(g); });
      EXPECT_EQ(named, expected) << f;
    }
  }
}

TEST(NormalFilters, SmoothAcrossTrianglesThatWindTheOtherWay) {
  const Shape shape = with_noise(sphere(3), 0.02);
  Shape mixed = shape;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  for (const Smooth& smooth : all_methods()) {
    // Few iterations: a median may jump between neighbours where rounding decides.
    const IterationOptions options{.iterations = 5};
    EXPECT_LT(largest_distance(smoothed(shape, smooth, options), smoothed(mixed, smooth, options)), 1e-4);
  }
}

/// A tilted plane patch with uneven triangles.
Shape uneven_plane() {
  Shape shape = with_noise(grid(12), 0.3, 7);
  for (Vec3d& p : shape.positions) p.z = 0.3 * p.x - 0.2 * p.y;
  return shape;
}

TEST(NormalFilters, KeepATiltedUnevenPlane) {
  for (const Smooth& smooth : all_methods()) {
    for (const Vec3d& p : smoothed(uneven_plane(), smooth).positions) {
      EXPECT_NEAR(p.z, 0.3 * p.x - 0.2 * p.y, 2e-5);
    }
  }
}

// ---- What each is for ----

TEST(NormalFilters, KeepTheEdgesOfANoisyCubeThatLaplacianRounds) {
  const Shape clean = cube(12), noisy = with_noise(clean, 0.03);
  const Shape rounded =
      smoothed(noisy, [](Surface& s, const IterationOptions& o) { return smooth_laplacian(s, {}, o, {}); });
  for (const Smooth& smooth : {median_normals(), fast_effective(), joint_bilateral(), bilateral_normals(),
                               bilateral_normals(kGlobal)}) {
    const Shape result = smoothed(noisy, smooth);
    EXPECT_LT(edge_error(clean, result), 0.25 * edge_error(clean, rounded));
    EXPECT_LT(std::abs(volume(result) - 8), 0.1 * std::abs(volume(rounded) - 8));
  }
}

TEST(JointBilateral, KeepsEveryVertexWithinItsDistance) {
  const Shape shape = with_noise(sphere(3), 0.05);
  const Surface surface = surface_of(shape);
  const double h = surface.mean_edge * surface.mesh.frame.scale();
  for (const double distance : {0.05, 0.2}) {
    const Shape result = smoothed(shape, joint_bilateral({.distance = distance}));
    EXPECT_LE(largest_distance(shape, result), distance * h);
    EXPECT_GT(largest_distance(shape, result), 0.9 * distance * h);
    const Shape held = smoothed(shape, joint_bilateral({.distance = distance}),
                                {.constraints = {.max_displacement = 0.01 * surface.mean_edge}});
    EXPECT_LE(largest_distance(shape, held), 0.01 * h) << "the caller's bound is tighter";
  }
}

TEST(JointBilateral, HoldsTheDistanceAfterEveryStepOfTheVertices) {
  const Shape shape = with_noise(sphere(2), 0.05);
  const Surface surface = surface_of(shape);
  const JointBilateralParams params{.vertex_steps = 3, .distance = 0.1};
  const Shape result = smoothed(shape, joint_bilateral(params), {.iterations = 20});
  // Vertices at the bound are pulled back to it or, where that rounds beyond, a 64th less.
  EXPECT_LT(largest_distance(result, oracle_joint_bilateral(shape, params, 20)),
            0.03 * params.distance * surface.mean_edge * surface.mesh.frame.scale());
}

TEST(Ohtake, ImprovesTheTrianglesOfAnUnevenPlane) {
  Surface surface = surface_of(uneven_plane());
  const auto before = surface.mesh.positions;
  ASSERT_TRUE(smooth_ohtake(surface, {}, {}, {}));
  const auto change = measure_change(surface, before, surface.mesh.positions, {});
  ASSERT_TRUE(change);
  EXPECT_GT(change->smallest_angle_after, change->smallest_angle_before + 2);
}

}  // namespace
}  // namespace burnish
