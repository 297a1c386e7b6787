#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "core/measure/error.h"
#include "core/measure/nearest.h"
#include "core/measure/quality.h"
#include "core/measure/triangle_sums.h"
#include "core/mesh/curve.h"
#include "core/run/math.h"
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

TEST(VertexDistances, AreWhatTheErrorsSumUp) {
  const Shape reference = testing::scaled(sphere(3), 40);
  for (const bool corresponding : {true, false}) {
    const Shape result = corresponding ? testing::with_noise(reference, 0.5) : testing::scaled(cube(9), 23);
    const Surface a = surface_of(result), b = surface_of(reference);
    const auto distances =
        vertex_distances(a, a.mesh.positions, b, b.mesh.positions, corresponding, {.threads = 2});
    ASSERT_TRUE(distances);
    ASSERT_EQ(distances->size(), a.mesh.positions.size());
    const ErrorMeasures measures = measure(result, reference, corresponding);
    double sum = 0;
    for (const double distance : *distances) sum += distance;
    EXPECT_NEAR(sum / static_cast<double>(distances->size()), measures.mean_distance, 1e-9);
    EXPECT_EQ(*std::max_element(distances->begin(), distances->end()), measures.max_distance);
  }
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

/// Straight from the definition: the projection when it is inside, else the nearest of three segments.
long double plain_squared_distance(const Vec3d& p, const Vec3d (&corners)[3]) {
  using Vec = Vec3<long double>;
  const auto widened = [](const Vec3d& v) { return Vec{v.x, v.y, v.z}; };
  const Vec point = widened(p), t[3] = {widened(corners[0]), widened(corners[1]), widened(corners[2])};
  const Vec normal = cross(t[1] - t[0], t[2] - t[0]);
  long double least = std::numeric_limits<long double>::infinity();
  bool inside = dot(normal, normal) > 0;
  for (int i = 0; i < 3; ++i) {
    const Vec along = t[(i + 1) % 3] - t[i], from = point - t[i];
    inside = inside && dot(cross(along, from), normal) >= 0;
    const long double size = dot(along, along),
                      share = size > 0 ? std::clamp(dot(from, along) / size, 0.0L, 1.0L) : 0;
    const Vec rest = from - along * share;
    least = std::min(least, dot(rest, rest));
  }
  const long double height = dot(point - t[0], normal);
  return inside ? height * height / dot(normal, normal) : least;
}

TEST(SquaredDistance, AgreesWithItsDefinitionForTrianglesOfAnyShape) {
  std::mt19937_64 random(11);
  const auto any = [&] { return static_cast<double>(static_cast<float>(random() >> 40)) * 0x1p-23 - 1; };
  for (int i = 0; i < 20'000; ++i) {
    Vec3d t[3] = {{any(), any(), any()}, {any(), any(), any()}, {any(), any(), any()}};
    const double flatness = std::ldexp(1.0, -(i % 40));  // down to a line
    t[2] = t[0] + (t[1] - t[0]) * any() + (t[2] - t[0]) * flatness;
    std::swap(t[i % 3], t[2]);
    const double near = std::ldexp(1.0, -(i % 30));
    const Vec3d p = t[0] + (t[1] - t[0]) * std::abs(any()) + (t[2] - t[0]) * std::abs(any() / 2) +
                    Vec3d{any(), any(), any()} * near;
    EXPECT_NEAR(std::sqrt(squared_distance(p, t[0], t[1], t[2])),
                static_cast<double>(std::sqrt(plain_squared_distance(p, t))), i % 40 < 16 ? 1e-10 : 1e-7)
        << i;
  }
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

/// The least of all triangles for each point, from a bound as the report has it: the distance of some corner.
void expect_group_nearest(const Mesh& mesh, std::span<const Vec3f> points) {
  const auto nearest = NearestTriangle::build(mesh.positions, mesh.triangles, {});
  ASSERT_TRUE(nearest);
  for (std::size_t first = 0; first < points.size(); first += NearestTriangle::kGroup) {
    const auto group = points.subspan(first, std::min(NearestTriangle::kGroup, points.size() - first));
    std::vector<double> squared, best;
    for (const Vec3f& point : group) {
      const Vec3d p = to_double(point);
      double bound = std::numeric_limits<double>::infinity(), least = bound;
      for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d way = p - to_double(mesh.positions[a]);
        bound = std::min(bound, dot(way, way));
        least = std::min(least, squared_distance(p, to_double(mesh.positions[a]),
                                                 to_double(mesh.positions[b]), to_double(mesh.positions[c])));
      }
      squared.push_back(bound);
      best.push_back(least);
    }
    nearest->find_all(group, squared, 0, {});
    EXPECT_EQ(squared, best) << mesh.triangles.size() << " triangles, points from " << first;
  }
}

TEST(NearestTriangle, AgreesWithTryingAllForGroups) {
  const Surface s = surface_of(with_noise(sphere(3), 0.1));
  expect_group_nearest(s.mesh, s.mesh.positions);
  expect_group_nearest(s.mesh, surface_of(with_noise(sphere(3), 0.05)).mesh.positions);
  expect_group_nearest(s.mesh, surface_of(with_noise(scaled(sphere(2), 0.7), 0.5)).mesh.positions);
  for (const std::size_t triangles : {1, 7, 8, 9, 64, 65, 513}) {
    Mesh part = s.mesh;
    part.triangles.resize(triangles);
    expect_group_nearest(part, std::span(s.mesh.positions).first(40));
  }
}

TEST(NearestTriangle, AgreesWithTryingAllForNeedlesFansAndOutliers) {
  Mesh mesh = surface_of(with_noise(grid(12), 0.2)).mesh;
  const auto first = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back({1e9F, -1e9F, 1e9F});  // far from all others, so all others share a cell
  mesh.positions.push_back({0.01F, 0.01F, 1e-7F});
  mesh.positions.push_back({0.02F, 0.02F, 1e-7F});
  for (Index v = 0; v + 1 < first; v += 5) mesh.triangles.push_back({first, v, v + 1});      // a fan
  for (Index v = 0; v < first; v += 3) mesh.triangles.push_back({first + 1, first + 2, v});  // around an edge
  mesh.triangles.push_back({first + 1, first + 1, first + 2});                               // a line
  expect_group_nearest(mesh, mesh.positions);
}

TEST(NearestTriangle, AgreesWithTryingAllForFlatTriangles) {
  Mesh mesh;
  std::vector<Vec3f> points;
  for (int i = 0; i < 40; ++i) {  // strips of triangles that are nearly lines, or are
    const auto x = static_cast<float>(i), width = std::ldexp(1.0F, -i);
    const auto first = static_cast<Index>(mesh.positions.size());
    for (const Vec3f& p : {Vec3f{x, 0.1F, 0.3F}, Vec3f{x, 0.9F, -0.4F}, Vec3f{x + width, 0.37F, 0.0637F}}) {
      mesh.positions.push_back(p);
      points.push_back(p);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    for (const float y : {0.2F, 0.5F, 0.8F}) points.push_back({x + width / 4, y, 0.3F - 0.875F * (y - 0.1F)});
  }
  expect_group_nearest(mesh, points);
}

TEST(NearestTriangle, AgreesWithTryingAllForGroupsOfAnySize) {
  // Products of four lengths leave what float can hold on both sides; so do squares, at the smallest.
  for (const float size : {1e-25F, 1e-18F, 1e-9F, 1e-3F, 1e7F, 1e12F, 1e17F}) {
    Mesh mesh = surface_of(with_noise(sphere(3), 0.1)).mesh;
    std::vector<Vec3f> points = surface_of(with_noise(sphere(3), 0.06)).mesh.positions;
    for (Vec3f& p : mesh.positions) p = p * size;
    for (Vec3f& p : points) p = p * size;
    expect_group_nearest(mesh, points);
  }
}

TEST(NearestTriangle, AgreesWithTryingAllWhereManyTrianglesAreEquallyNear) {
  Mesh mesh = surface_of(grid(30)).mesh;
  std::vector<Vec3f> points;  // over corners, middles of sides and faces, and nearly so
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3f pa = mesh.positions[a], pb = mesh.positions[b], pc = mesh.positions[c];
    for (Vec3f p : {pa, (pa + pb) * 0.5F, (pa + pb + pc) * (1.0F / 3)}) {
      p.z += 0.01F;
      points.push_back(p);
      points.push_back(p * (1 + 0x1p-22F));
    }
  }
  expect_group_nearest(mesh, points);
}

TEST(NearestTriangle, AgreesWithTryingAllWhenEveryTriangleIsNearEveryPoint) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> at(-1, 1);
  Mesh mesh;
  for (Index first = 0; first < 3 * 960; first += 3) {  // as many as one walk takes
    for (int c = 0; c < 3; ++c) mesh.positions.push_back({at(random), at(random), at(random)});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  std::vector<Vec3f> points;
  for (int i = 0; i < 64; ++i)
    points.push_back({5 + at(random), at(random), at(random)});  // all about as far
  expect_group_nearest(mesh, points);
}

TEST(NearestTriangle, GivesTheSameBitsForEveryVectorWidth) {
  const Surface s = surface_of(with_noise(sphere(4), 0.02));
  std::vector<nearest_group::Node> nodes(1 + 8);  // a tree of 64 triangles by hand
  std::vector<Index> triangles(64);
  std::iota(triangles.begin(), triangles.end(), Index{0});
  const auto include = [](nearest_group::Node& node, std::size_t k, const Vec3f& p, bool start) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.low[axis][k] = start ? p[axis] : std::min(node.low[axis][k], p[axis]);
      node.high[axis][k] = start ? p[axis] : std::max(node.high[axis][k], p[axis]);
    }
  };
  for (std::size_t t = 0; t < 64; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3f& p = s.mesh.positions[s.mesh.triangles[t][c]];
      include(nodes[1 + t / 8], t % 8, p, c == 0);
      include(nodes[0], t / 8, p, t % 8 == 0 && c == 0);
    }
  }
  std::vector<SimdVec3> positions;
  for (const Vec3f& p : s.mesh.positions) positions.emplace_back(p);
  const nearest_group::Tree tree{nodes, 9, triangles, s.mesh.triangles, positions};
  const auto points = std::span(s.mesh.positions).first(nearest_group::kMost);
  std::vector<std::vector<double>> answers;
  for (const auto find : nearest_group::finds_here()) {
    auto& answer = answers.emplace_back(points.size(), 4.0);
    ASSERT_TRUE(find(tree, points, answer));
    EXPECT_EQ(answer, answers.front());
  }
}

TEST(NearestTriangle, AgreesWithTryingAllWhenTheTrianglesAreShuffled) {
  const Surface s = surface_of(with_noise(sphere(3), 0.1));
  Mesh mesh = s.mesh;
  const auto order = shuffled(mesh.triangles.size());
  for (std::size_t t = 0; t < order.size(); ++t) mesh.triangles[t] = s.mesh.triangles[order[t]];
  expect_group_nearest(mesh, mesh.positions);
}

TEST(TriangleSums, AreTheSameBitsForEveryVectorWidthAndSayWhatTheFormulaSays) {
  const Surface s = surface_of(with_noise(sphere(2), 0.02)), other = surface_of(with_noise(sphere(2), 0.1));
  const auto& positions = s.mesh.positions;
  const std::vector<double> squared(positions.size(), 2);
  for (const std::size_t count : {1, 2, 3, 4, 7, 320}) {
    const std::span triangles = std::span(s.mesh.triangles).first(count);
    double area = 0, angles = 0;
    for (const auto& [a, b, c] : triangles) {
      const auto normal = [&, a = a, b = b, c = c](const auto& at) {
        return cross(to_double(at[b]) - to_double(at[a]), to_double(at[c]) - to_double(at[a]));
      };
      const Vec3d ours = normal(positions), theirs = normal(other.mesh.positions);
      area += length(ours) / 2;
      angles += portable_angle(length(cross(ours, theirs)), dot(ours, theirs));
    }
    for (const auto& functions : triangle_sums::functions_here()) {
      const auto shape = functions.shape(triangles, positions);
      const auto errors = functions.errors(triangles, positions, squared, other.mesh.positions);
      EXPECT_NEAR(shape.area, area, 1e-12 * area) << count;
      EXPECT_NEAR(errors.area, area, 1e-12 * area) << count;
      EXPECT_NEAR(errors.weighted, 6 * area, 1e-11 * area) << count;
      EXPECT_NEAR(errors.angles, angles, 1e-12 * angles) << count;
      EXPECT_EQ(errors.compared, count);
      const auto first = triangle_sums::functions_here().front();
      EXPECT_EQ(shape.volume, first.shape(triangles, positions).volume);
      EXPECT_EQ(errors.angles, first.errors(triangles, positions, squared, other.mesh.positions).angles);
    }
  }
}

TEST(CurveOrder, TakesEveryPointOnceAndNearOnesTogether) {
  Surface s = surface_of(with_noise(sphere(4), 0.01));
  std::vector<Vec3f> points;
  for (const Index v : shuffled(s.mesh.positions.size())) points.push_back(s.mesh.positions[v]);
  points.push_back({1e12F, 0, 0});  // the others must still be told apart
  const auto order = curve_order(points, {});
  EXPECT_EQ(std::set<Index>(order.begin(), order.end()).size(), points.size());
  double way = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (order[i] != points.size() - 1 && order[i - 1] != points.size() - 1)
      way += length(to_double(points[order[i]] - points[order[i - 1]]));
  }
  EXPECT_LT(way / static_cast<double>(order.size()), 3 * s.mean_edge);
  EXPECT_EQ(curve_order(std::vector<Vec3f>(100), {}).back(), 99U);
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
