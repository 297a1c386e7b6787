#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/run/math.h"
#include "core/shape/noise.h"
#include "core/shape/sample.h"

namespace burnish {
namespace {

Shape sample(unsigned resolution) {
  Result<Shape> shape = make_sample(resolution);
  EXPECT_TRUE(shape.ok());
  return std::move(*shape);
}

Surface surface_of(const Shape& shape) {
  Result<Surface> surface = prepare_surface(shape.positions, shape.triangles, {});
  EXPECT_TRUE(surface.ok());
  return std::move(*surface);
}

Vec3d normal_of(const Shape& shape, const Triangle& t) {
  const Vec3d a = shape.positions[t[0]];
  return cross(shape.positions[t[1]] - a, shape.positions[t[2]] - a);
}

double smallest_angle_degrees(const Shape& shape) {
  double smallest = 180;
  for (const Triangle& t : shape.triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3d p = shape.positions[t[corner]];
      const Vec3d a = shape.positions[t[(corner + 1) % 3]] - p;
      const Vec3d b = shape.positions[t[(corner + 2) % 3]] - p;
      smallest = std::min(smallest, std::atan2(length(cross(a, b)), dot(a, b)) * kDegreesPerRadian);
    }
  }
  return smallest;
}

TEST(MakeSample, IsOneClosedManifoldLikeASphere) {
  const Shape shape = sample(kSampleResolution);
  const Surface surface = surface_of(shape);
  EXPECT_EQ(shape.triangles.size(), 12u * 44 * 44);
  EXPECT_EQ(surface.welded_vertices + surface.degenerate_triangles + surface.duplicate_triangles, 0u);
  EXPECT_EQ(surface.topology.boundary_edges + surface.topology.non_manifold_edges, 0u);
  EXPECT_EQ(surface.topology.opposed_edges + surface.topology.non_manifold_vertices, 0u);
  EXPECT_EQ(surface.topology.components, 1u);
  EXPECT_EQ(shape.positions.size() + shape.triangles.size() - surface.topology.edges, 2u);
}

TEST(MakeSample, WindsItsTrianglesOutwards) {
  const Shape shape = sample(8);
  double six_volumes = 0;
  for (const Triangle& t : shape.triangles) six_volumes += dot(shape.positions[t[0]], normal_of(shape, t));
  EXPECT_GT(six_volumes / 6, 0.9e6);  // mm^3; the cube alone has 1e6
  EXPECT_LT(six_volumes / 6, 1.2e6);
}

TEST(MakeSample, HasNoThinTriangles) { EXPECT_GT(smallest_angle_degrees(sample(kSampleResolution)), 25.0); }

TEST(MakeSample, RunsItsCreasesAlongEdges) {
  const Shape shape = sample(kSampleResolution);
  std::set<std::tuple<long, long, long>>
      normals;  // of the pyramid on the side x = +50 mm and the flat around it
  for (const Triangle& t : shape.triangles) {
    const Vec3d centre = (shape.positions[t[0]] + shape.positions[t[1]] + shape.positions[t[2]]) * (1.0 / 3);
    if (centre.x < 50 - 1e-9 || std::abs(centre.y) > 49.9 || std::abs(centre.z) > 49.9) continue;
    const Vec3d n = normal_of(shape, t) * (1 / length(normal_of(shape, t)));
    normals.emplace(std::lround(n.x * 1e6), std::lround(n.y * 1e6), std::lround(n.z * 1e6));
  }
  EXPECT_EQ(normals.size(), 5u);  // one triangle across a crease would add a sixth direction
}

TEST(MakeSample, RoundsTheResolutionUpToFours) {
  EXPECT_EQ(sample(5).triangles.size(), sample(8).triangles.size());
  EXPECT_EQ(sample(4).triangles.size(), 12u * 16);
}

TEST(MakeSample, RefusesResolutionsOutOfRange) {
  for (const unsigned resolution : {0u, 3u, 1001u, std::numeric_limits<unsigned>::max()}) {
    const Result<Shape> shape = make_sample(resolution);
    ASSERT_FALSE(shape.ok()) << resolution;
    EXPECT_EQ(shape.error().cause, Cause::BadOption);
    EXPECT_EQ(shape.error().field, "resolution");
  }
}

/// Displacements in mean edge lengths that noise gave to the sample's vertices.
std::vector<Vec3d> displacements(const NoiseOptions& options) {
  Surface surface = surface_of(sample(kSampleResolution));
  const std::vector<Vec3f> before = surface.mesh.positions;
  EXPECT_TRUE(add_noise(surface, options).ok());
  std::vector<Vec3d> moves;
  for (std::size_t v = 0; v < before.size(); ++v) {
    moves.push_back((to_double(surface.mesh.positions[v]) - to_double(before[v])) * (1 / surface.mean_edge));
  }
  return moves;
}

double rms(const std::vector<Vec3d>& moves) {
  double sum = 0;
  for (const Vec3d& move : moves) sum += dot(move, move);
  return std::sqrt(sum / static_cast<double>(moves.size()));
}

double largest(const std::vector<Vec3d>& moves) {
  double size = 0;
  for (const Vec3d& move : moves) size = std::max(size, length(move));
  return size;
}

TEST(AddNoise, GaussianHasTheAmplitudeAsDeviation) {
  const std::vector<Vec3d> moves = displacements({.kind = NoiseKind::Gaussian, .amplitude = 0.3});
  EXPECT_NEAR(rms(moves), 0.3, 0.01);
  EXPECT_GT(largest(moves), 0.3 * 3);  // one in 370 lies beyond three deviations
  std::ptrdiff_t within = 0;
  for (const Vec3d& move : moves) within += length(move) < 0.3 ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(within) / static_cast<double>(moves.size()), 0.6827, 0.02);
}

TEST(AddNoise, UniformStaysWithinTheAmplitude) {
  const std::vector<Vec3d> moves = displacements({.kind = NoiseKind::Uniform, .amplitude = 0.3});
  EXPECT_NEAR(rms(moves), 0.3 / std::sqrt(3.0), 0.01);
  EXPECT_LE(largest(moves), 0.3 * 1.0001);
}

TEST(AddNoise, ImpulsiveHitsTheFraction) {
  const std::vector<Vec3d> moves =
      displacements({.kind = NoiseKind::Impulsive, .amplitude = 0.5, .fraction = 0.2});
  const auto hit = std::count_if(moves.begin(), moves.end(), [](const Vec3d& m) { return length(m) > 0; });
  EXPECT_NEAR(static_cast<double>(hit) / static_cast<double>(moves.size()), 0.2, 0.02);
}

TEST(AddNoise, RandomDirectionMovesEachCoordinateAlike) {
  const std::vector<Vec3d> moves = displacements({.direction = NoiseDirection::Random, .amplitude = 0.3});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (const Vec3d& move : moves) sum += move[axis] * move[axis];
    EXPECT_NEAR(std::sqrt(sum / static_cast<double>(moves.size())), 0.3, 0.01) << "axis " << axis;
  }
}

TEST(AddNoise, NormalDirectionMovesFlatPartsStraight) {
  const Shape shape = sample(kSampleResolution);
  const std::vector<Vec3d> moves = displacements({.amplitude = 0.3});
  int checked = 0;
  for (std::size_t v = 0; v < moves.size(); ++v) {
    const Vec3d p = shape.positions[v];
    if (p.z > -50 || std::abs(p.x) > 49.9 || std::abs(p.y) > 49.9) continue;  // the inside of the flat base
    EXPECT_LT(std::abs(moves[v].x) + std::abs(moves[v].y), 1e-5);
    ++checked;
  }
  EXPECT_EQ(checked, 43 * 43);
}

TEST(AddNoise, RepeatsItselfForASeedOnly) {
  const NoiseOptions first{.seed = 7}, second{.seed = 8};
  EXPECT_EQ(displacements(first), displacements(first));
  EXPECT_NE(displacements(first), displacements(second));
}

TEST(AddNoise, DoesNothingAtAmplitudeZero) { EXPECT_EQ(largest(displacements({.amplitude = 0})), 0.0); }

TEST(AddNoise, MovesRepeatedPositionsAsOneAndLeavesIsolatedOnes) {
  const std::vector<Vec3d> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0},
                                        {0, 1, 0}, {1, 1, 1}, {9, 9, 9}};
  const std::vector<Triangle> triangles = {{0, 1, 2}, {3, 5, 4}};  // a seam: 1 = 3 and 2 = 4
  Result<Surface> surface = prepare_surface(positions, triangles, {});
  ASSERT_TRUE(surface.ok());
  const std::vector<Vec3f> before = surface->mesh.positions;
  ASSERT_TRUE(add_noise(*surface, {.direction = NoiseDirection::Random, .amplitude = 1}).ok());
  const MovedPositions moved{positions, surface->weld, before, surface->mesh.positions, surface->mesh.frame};
  EXPECT_TRUE(moved.moved(1));
  EXPECT_EQ(moved.at(1), moved.at(3));
  EXPECT_EQ(moved.at(2), moved.at(4));
  EXPECT_FALSE(moved.moved(6));
}

TEST(AddNoise, NamesTheOptionToBlame) {
  Surface surface = surface_of(sample(4));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double amplitude : {-0.1, 101.0, nan}) {
    const Result<> added = add_noise(surface, {.amplitude = amplitude});
    ASSERT_FALSE(added.ok()) << amplitude;
    EXPECT_EQ(added.error().field, "amplitude");
  }
  for (const double fraction : {-0.1, 1.1, nan}) {
    const Result<> added = add_noise(surface, {.fraction = fraction});
    ASSERT_FALSE(added.ok()) << fraction;
    EXPECT_EQ(added.error().field, "fraction");
  }
}

}  // namespace
}  // namespace burnish
