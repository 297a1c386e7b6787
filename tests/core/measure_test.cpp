#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/measure/error.h"
#include "core/measure/nearest.h"
#include "core/measure/quality.h"
#include "tests/support/oracle.h"

namespace burnish {
namespace {

using namespace burnish::testing;

ErrorMeasures measure(const Shape& result, const Shape& reference, bool corresponding = true,
                      unsigned threads = 1) {
  const Surface a = surface_of(result), b = surface_of(reference);
  const auto measures =
      measure_errors(a, a.mesh.positions, b, b.mesh.positions, corresponding, {.threads = threads});
  EXPECT_TRUE(measures);
  return *measures;
}

TEST(SquaredDistance, FindsFacesEdgesAndCorners) {
  const Vec3d a{0, 0, 0}, b{4, 0, 0}, c{0, 4, 0};
  EXPECT_DOUBLE_EQ(squared_distance({1, 1, 3}, a, b, c), 9);          // above the face
  EXPECT_DOUBLE_EQ(squared_distance({1, -2, 0}, a, b, c), 4);         // beside an edge
  EXPECT_DOUBLE_EQ(squared_distance({4, 4, 0}, a, b, c), 8);          // beside the long edge
  EXPECT_DOUBLE_EQ(squared_distance({-3, -4, 0}, a, b, c), 25);       // off a corner
  EXPECT_DOUBLE_EQ(squared_distance({2, 3, 0}, a, b, {2, 0, 0}), 9);  // a line
  EXPECT_DOUBLE_EQ(squared_distance({0, 3, 4}, a, a, a), 25);         // a point
}

/// Asks for each point, from some start, and compares with the best of all triangles.
void expect_nearest(const Mesh& mesh, std::size_t triangles, std::span<const Vec3f> points) {
  const std::span all(mesh.triangles.data(), triangles);
  const auto nearest = NearestTriangle::build(mesh.positions, all, {});
  ASSERT_TRUE(nearest);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d p = to_double(points[i]);
    double best = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : all) {
      best = std::min(best, squared_distance(p, to_double(mesh.positions[a]), to_double(mesh.positions[b]),
                                             to_double(mesh.positions[c])));
    }
    EXPECT_EQ(nearest->find(points[i], static_cast<Index>(i % triangles)).squared_distance, best)
        << triangles << " triangles, point " << i;
  }
}

TEST(NearestTriangle, AgreesWithTryingAllFromAnyStart) {
  const Surface s = surface_of(with_noise(sphere(3), 0.1));
  const Surface points = surface_of(with_noise(scaled(sphere(2), 0.7), 0.5));
  expect_nearest(s.mesh, s.mesh.triangles.size(), points.mesh.positions);
}

TEST(NearestTriangle, AgreesWithTryingAllForAnyNumberOfTriangles) {
  const Surface s = surface_of(with_noise(sphere(3), 0.1));
  for (const std::size_t triangles : {1, 2, 7, 8, 9, 63, 64, 65, 511, 512, 513}) {
    expect_nearest(s.mesh, triangles, std::span(s.mesh.positions).first(40));
  }
}

TEST(NearestTriangle, AgreesWithTryingAllFromFarAway) {
  const Surface s = surface_of(with_noise(sphere(3), 0.1));
  const std::vector<Vec3f> points{
      {1e3F, 2e3F, -5e2F}, {0, 1e6F, 0}, {1e12F, 1e12F, 1e12F}, {-1e18F, 0, 1e18F}};
  expect_nearest(s.mesh, s.mesh.triangles.size(), points);
}

TEST(Ev, AgreesWithBruteForce) {
  const Shape reference = with_noise(sphere(2), 0.02);
  const Shape result = with_noise(reference, 0.05, 9);
  const ErrorMeasures m = measure(result, reference);
  const double expected = oracle_ev(result, reference);
  EXPECT_NEAR(m.ev, expected, 1e-6 * expected);
  EXPECT_NEAR(m.ev_over_edge, expected / oracle_mean_edge(reference), 1e-6);
  EXPECT_NEAR(measure(result, reference, false).ev, expected, 1e-6 * expected);
}

TEST(Ev, IsZeroAgainstItself) {
  const ErrorMeasures m = measure(sphere(2), sphere(2));
  EXPECT_EQ(m.ev, 0);
  EXPECT_EQ(m.max_distance, 0);
  EXPECT_EQ(*m.mean_normal_degrees, 0);
  EXPECT_EQ(*m.flipped_triangles, 0U);
}

TEST(Ev, IsTheShiftOfAPlaneForAPlane) {
  const ErrorMeasures m = measure(moved(grid(6), {0, 0, 0.25}), grid(6));
  EXPECT_NEAR(m.ev, 0.25,
              1e-6);  // every vertex is 0.25 away, and the vertices' areas sum to three times the whole
  EXPECT_NEAR(m.mean_distance, 0.25, 1e-6);
  EXPECT_NEAR(m.rms_distance, 0.25, 1e-6);
  EXPECT_NEAR(m.max_distance, 0.25, 1e-6);
  EXPECT_NEAR(m.ev_over_diagonal, 0.25 / (6 * std::sqrt(2.0)), 1e-6);
  EXPECT_NEAR(*m.max_normal_degrees, 0, 1e-4);
}

TEST(Ev, ScalesWithTheModelAndItsRatiosDoNot) {
  const Shape reference = sphere(2), result = with_noise(reference, 0.03);
  const ErrorMeasures one = measure(result, reference),
                      big = measure(scaled(result, 1000), scaled(reference, 1000));
  EXPECT_NEAR(big.ev, 1000 * one.ev, 1e-3 * one.ev * 1000);
  EXPECT_NEAR(big.ev_over_edge, one.ev_over_edge, 1e-5);
  EXPECT_NEAR(big.ev_over_diagonal, one.ev_over_diagonal, 1e-6);
}

TEST(Ev, IsTheSameForAnyNumberOfThreads) {
  const Shape reference = sphere(5), result = with_noise(reference, 0.01);
  EXPECT_EQ(measure(result, reference, true, 1).ev, measure(result, reference, true, 3).ev);
}

TEST(ErrorMeasures, CountFlippedTriangles) {
  Shape result = grid(4);
  result.positions[12] = {-0.6, 2, 0};  // dragged over its left neighbours
  const ErrorMeasures m = measure(result, grid(4));
  EXPECT_GT(*m.flipped_triangles, 0U);
  EXPECT_NEAR(*m.max_normal_degrees, 180, 1e-6);
}

TEST(ErrorMeasures, LeaveNormalsUnsetForOtherConnectivity) {
  const ErrorMeasures m = measure(sphere(3), sphere(2), false);
  EXPECT_FALSE(m.mean_normal_degrees);
  EXPECT_FALSE(m.flipped_triangles);
  EXPECT_GT(m.max_distance, 0);
  EXPECT_LT(m.max_distance, 0.05);
}

TEST(ErrorMeasures, StayFiniteForAReferenceFromAnotherWorld) {
  const ErrorMeasures m = measure(scaled(sphere(1), 1e-30), moved(scaled(sphere(1), 1e20), {1e30, 0, 0}));
  EXPECT_TRUE(std::isfinite(m.ev));
  EXPECT_GT(m.ev, 0);
}

TEST(ErrorMeasures, AreZeroForAMeshWithoutArea) {
  const Shape point{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}};
  const ErrorMeasures m = measure(point, point);
  EXPECT_EQ(m.ev, 0);
  EXPECT_EQ(m.ev_over_edge, 0);
}

TEST(MeshChange, KnowsAreaVolumeAndAnglesOfACube) {
  const Surface before = surface_of(cube(4));
  auto after = before.mesh.positions;
  for (Vec3f& p : after) p *= 0.5F;
  const auto change = measure_change(before, before.mesh.positions, after, {});
  ASSERT_TRUE(change);
  EXPECT_NEAR(change->area_percent, -75, 1e-4);
  EXPECT_NEAR(change->volume_percent, -87.5, 1e-4);
  EXPECT_NEAR(change->smallest_angle_before, 45, 1e-4);
  EXPECT_NEAR(change->smallest_angle_after, 45, 1e-4);
  EXPECT_NEAR(change->max_displacement, std::sqrt(3.0) / 2, 1e-6);
  EXPECT_LT(change->rms_displacement, change->max_displacement);
}

TEST(MeshChange, GivesNoVolumePercentForAFlatMesh) {
  const Surface flat = surface_of(grid(4));
  auto after = flat.mesh.positions;
  after[12].z += 0.1F;
  const auto change = measure_change(flat, flat.mesh.positions, after, {});
  EXPECT_EQ(change->volume_percent, 0);
  EXPECT_GT(change->area_percent, 0);
}

}  // namespace
}  // namespace burnish
