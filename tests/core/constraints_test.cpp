// What all methods keep to: pinned vertices, locked features, the volume.
#include "core/smooth/constraints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/smooth/registry.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using namespace burnish::testing;
using Given = std::map<std::string, ParameterValue>;

std::vector<std::string> smooth(Surface& surface, const std::string& name, const Given& given) {
  const Method& method = **find_method(name);
  const auto values = resolve_parameters(method, given);
  EXPECT_TRUE(values) << values.error().message;
  const auto outcome = method.run(surface, *values, {});
  EXPECT_TRUE(outcome) << name;
  std::vector<std::string> codes;
  if (!outcome) return codes;
  for (const Warning& warning : outcome->warnings) codes.push_back(warning.code);
  return codes;
}

const Given kKeepVolume = {{"preserve_volume", "yes"}};

Given with(Given given, const std::string& name, ParameterValue value) {
  given[name] = std::move(value);
  return given;
}

/// Positions after smoothing, in the file's frame and order.
std::vector<Vec3d> positions_of(const Surface& surface) {
  std::vector<Vec3d> positions;
  for (const Index v : surface.weld) {
    positions.push_back(surface.mesh.frame.to_file(to_double(surface.mesh.positions[v])));
  }
  return positions;
}

class AnyMethod : public ::testing::TestWithParam<std::string> {};

TEST_P(AnyMethod, LeavesPinnedVerticesToTheBit) {
  struct Row {
    Shape shape;
    Given given;
  };
  const Row rows[] = {
      {with_noise(sphere(3), 0.03), {}},
      {with_noise(sphere(3), 0.03), kKeepVolume},
      {with_noise(grid(9), 0.1), {{"boundary", "free"}}},
      {with_noise(cube(5), 0.02), {{"lock_features", 60.0}, {"preserve_volume", "yes"}}},
  };
  for (const Row& row : rows) {
    Surface surface = surface_of(row.shape);
    const auto before = surface.mesh.positions;
    surface.pinned.assign(before.size(), 0);
    for (std::size_t v = 0; v < before.size(); v += 4) surface.pinned[v] = 1;
    smooth(surface, GetParam(), row.given);
    std::size_t moved = 0;
    for (std::size_t v = 0; v < before.size(); ++v) {
      const bool stays = surface.mesh.positions[v] == before[v];
      ASSERT_TRUE(stays || surface.pinned[v] == 0) << v;
      moved += !stays;
    }
    EXPECT_GT(moved, before.size() / 3);
  }
}

INSTANTIATE_TEST_SUITE_P(Constraints, AnyMethod, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const Method& method : methods()) names.push_back(method.name);
                           return names;
                         }()),
                         [](const auto& row) { return row.param; });

// --- lock_features ---------------------------------------------------------------------------------------

/// How many coordinates of a place on the cube are at its side: 3 at a corner, 2 on an edge.
int sides(const Vec3d& p) { return (std::abs(p.x) == 1) + (std::abs(p.y) == 1) + (std::abs(p.z) == 1); }

/// A cube whose edges are straight and whose sides are rough.
Shape rough_cube(int n) {
  Shape shape = cube(n);
  const Shape rough = with_noise(shape, 0.3 / n);
  for (std::size_t v = 0; v < shape.positions.size(); ++v) {
    if (sides(shape.positions[v]) == 1) shape.positions[v] = rough.positions[v];
  }
  return shape;
}

/// Farthest that an edge of rough_cube() has left its line.
double off_the_edges(const Shape& cube, const std::vector<Vec3d>& after) {
  double farthest = 0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    if (sides(cube.positions[v]) != 2) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double side = cube.positions[v][axis];
      if (std::abs(side) == 1) farthest = std::max(farthest, std::abs(after[v][axis] - side));
    }
  }
  return farthest;
}

TEST_P(AnyMethod, KeepsTheLinesOfACubeWhenTheyAreLocked) {
  const Shape shape = rough_cube(8);
  Surface surface = surface_of(shape);
  const auto before = positions_of(surface);
  smooth(surface, GetParam(), {{"lock_features", 60.0}});
  const auto after = positions_of(surface);
  EXPECT_LT(off_the_edges(shape, after), 3e-7);
  std::size_t slid = 0, moved = 0, inside = 0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    const int at = sides(shape.positions[v]);
    EXPECT_TRUE(at < 3 || after[v] == before[v]) << "a corner";
    slid += at == 2 && length(after[v] - before[v]) > 1e-4;
    moved += at < 2 && !(after[v] == before[v]);
    inside += at < 2;
  }
  EXPECT_EQ(moved, inside) << "the sides are smoothed";
  EXPECT_GT(slid, 0U);
}

TEST(LockFeatures, MattersForTheCube) {
  const Shape shape = rough_cube(8);
  Surface surface = surface_of(shape);
  smooth(surface, "laplacian", {});
  EXPECT_GT(off_the_edges(shape, positions_of(surface)), 0.05);
}

using Edge = std::pair<Index, Index>;

/// Angles between the normals of the two triangles at each edge, in degrees. Without core's help.
std::map<Edge, double> angles_of(const Surface& surface) {
  std::map<Edge, std::vector<Vec3d>> normals;
  for (const Triangle& t : surface.mesh.triangles) {
    const auto at = [&](std::size_t corner) { return to_double(surface.mesh.positions[t[corner]]); };
    const Vec3d normal = cross(at(1) - at(0), at(2) - at(0));
    for (std::size_t c = 0; c < 3; ++c) {
      normals[std::minmax(t[c], t[(c + 1) % 3])].push_back(normal * (1 / length(normal)));
    }
  }
  std::map<Edge, double> angles;
  for (const auto& [edge, pair] : normals) {
    if (pair.size() != 2) continue;
    angles[edge] = std::acos(std::clamp(dot(pair[0], pair[1]), -1.0, 1.0)) * 57.29577951308232;
  }
  return angles;
}

double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const double along = dot(p - a, b - a) / dot(b - a, b - a);
  return length(p - (a + (b - a) * std::clamp(along, 0.0, 1.0)));
}

TEST(LockFeatures, HoldsEveryVertexByItsNumberOfSharpEdges) {
  for (const double degrees : {12.0, 25.0, 45.0, 70.0, 95.0}) {
    Surface surface = surface_of(with_noise(cube(6), 0.04));
    const auto before = surface.mesh.positions;
    std::map<Index, std::vector<Index>> sharp;  // far ends
    for (const auto& [edge, angle] : angles_of(surface)) {
      if (angle <= degrees) continue;
      sharp[edge.first].push_back(edge.second);
      sharp[edge.second].push_back(edge.first);
    }
    smooth(surface, "laplacian", {{"lock_features", degrees}});
    std::size_t free = 0;
    for (Index v = 0; v < before.size(); ++v) {
      const Vec3f& after = surface.mesh.positions[v];
      const auto& ends = sharp[v];
      if (ends.empty()) {
        ++free;
        EXPECT_NE(after, before[v]) << v;
      } else if (ends.size() == 2) {
        const auto to_rail = [&](Index end) {
          return distance_to_segment(to_double(after), to_double(before[v]), to_double(before[end]));
        };
        EXPECT_LT(std::min(to_rail(ends[0]), to_rail(ends[1])), 1e-7) << v;
      } else {
        EXPECT_EQ(after, before[v]) << v << " has " << ends.size();
      }
    }
    EXPECT_TRUE(free > 0 || degrees < 50) << degrees;
  }
}

TEST(LockFeatures, SlidesAlongBothEdgesOfAVertexAndNoFarther) {
  const Surface surface = surface_of(cube(4));
  const Constraints constraints(surface, {.lock_features = 60});
  for (std::size_t v = 0; v < surface.mesh.positions.size(); ++v) {
    const Vec3d place = surface.mesh.frame.to_file(to_double(surface.mesh.positions[v]));
    if (sides(place) != 2) continue;
    const Vec3f home = surface.mesh.positions[v];
    const std::size_t along = std::abs(place.x) != 1 ? 0 : std::abs(place.y) != 1 ? 1 : 2;
    for (const double way : {0.01, -0.01, 5.0, -5.0}) {
      std::vector<SimdVec3> to(surface.mesh.positions.begin(), surface.mesh.positions.end());
      Vec3f wanted = home, expected = home;
      for (std::size_t axis = 0; axis < 3; ++axis)
        wanted[axis] += static_cast<float>((axis == along ? 1 : 0.3) * way);
      // 4 squares of 0.5 on a side that is 2 long.
      const double most = 0.5 / surface.mesh.frame.scale();
      expected[along] += static_cast<float>(std::clamp(way, -most, most));
      to[v] = SimdVec3(wanted);
      ASSERT_TRUE(constraints.enforce(to, 0, to.size()));
      EXPECT_LT(length(to[v].vec3() - expected), 1e-6) << way;
    }
  }
}

TEST(Constraints, SayWhenAPositionHasLeftTheMesh) {
  const Surface surface = surface_of(sphere(1));
  const Constraints constraints(surface, {});
  const std::vector<SimdVec3> fine(surface.mesh.positions.begin(), surface.mesh.positions.end());
  for (const float bad : {std::nanf(""), INFINITY, -1.1e6F}) {
    auto to = fine;
    EXPECT_TRUE(constraints.enforce(to, 0, to.size()));
    to[7] = SimdVec3(0, bad, 0);
    EXPECT_FALSE(constraints.enforce(to, 0, to.size()));
    EXPECT_TRUE(constraints.enforce(to, 8, to.size())) << "only what it is asked for";
  }
}

TEST(LockFeatures, HoldsBothEndsOfALoneSharpEdge) {
  Surface surface = surface_of(with_noise(sphere(3), 0.03));
  const auto before = surface.mesh.positions;
  std::vector<std::pair<double, Edge>> sorted;
  for (const auto& [edge, angle] : angles_of(surface)) sorted.emplace_back(angle, edge);
  std::ranges::sort(sorted, std::greater());
  const double between = (sorted[0].first + sorted[1].first) / 2;
  smooth(surface, "laplacian", {{"lock_features", between}});
  const auto [a, b] = sorted[0].second;
  for (Index v = 0; v < before.size(); ++v) {
    EXPECT_EQ(surface.mesh.positions[v] == before[v], v == a || v == b) << v;
  }
}

TEST(LockFeatures, LocksNothingAtZeroAndAtAFullTurn) {
  const Surface original = surface_of(with_noise(cube(5), 0.1));
  Surface without = original;
  smooth(without, "laplacian", {});
  for (const double degrees : {0.0, 180.0}) {
    Surface surface = original;
    smooth(surface, "laplacian", {{"lock_features", degrees}});
    EXPECT_EQ(surface.mesh.positions, without.mesh.positions) << degrees;
  }
}

TEST(LockFeatures, TakesTrianglesThatWindAgainstEachOther) {
  const Shape shape = rough_cube(6);
  Shape mixed = shape;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3) {
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  }
  Surface one = surface_of(shape), other = surface_of(mixed);
  smooth(one, "laplacian", {{"lock_features", 60.0}});
  smooth(other, "laplacian", {{"lock_features", 60.0}});
  EXPECT_EQ(one.mesh.positions, other.mesh.positions);
}

TEST(LockFeatures, HoldsTogetherWithTheOtherConstraints) {
  const Shape shape = rough_cube(8);
  const Surface original = surface_of(shape);
  Surface surface = original;
  smooth(surface, "laplacian",
         {{"lock_features", 60.0}, {"max_displacement", 0.05}, {"preserve_volume", "yes"}});
  EXPECT_LT(off_the_edges(shape, positions_of(surface)), 3e-7);
  for (std::size_t v = 0; v < original.mesh.positions.size(); ++v) {
    const Vec3d way = to_double(surface.mesh.positions[v]) - to_double(original.mesh.positions[v]);
    EXPECT_LE(length(way), 0.05 * original.mean_edge);
  }
}

// --- preserve_volume -------------------------------------------------------------------------------------

/// What each triangle adds to the volume about the mean of the boundary, or the origin, in local units: the
/// fans that close holes add nothing there.
std::vector<double> volumes_of(const Surface& surface) {
  Vec3d centre;
  double boundary = 0;
  for (Index v = 0; v < surface.mesh.positions.size(); ++v) {
    if (!surface.topology.has(v, kBoundaryVertex)) continue;
    centre += to_double(surface.mesh.positions[v]);
    ++boundary;
  }
  if (boundary > 0) centre *= 1 / boundary;
  std::vector<double> volumes;
  for (const Triangle& t : surface.mesh.triangles) {
    const auto at = [&](std::size_t c) { return to_double(surface.mesh.positions[t[c]]) - centre; };
    volumes.push_back(dot(at(0), cross(at(1), at(2))) / 6);
  }
  return volumes;
}

double volume(const Surface& surface) {
  double sum = 0;
  for (const double each : volumes_of(surface)) sum += each;
  return sum;
}

TEST_P(AnyMethod, KeepsTheVolumeWhenAsked) {
  for (const Shape& shape : {sphere(4), with_noise(sphere(4), 0.01), with_noise(cube(8), 0.02)}) {
    Surface surface = surface_of(shape);
    const double before = volume(surface);
    EXPECT_THAT(smooth(surface, GetParam(), kKeepVolume), IsEmpty());
    EXPECT_NEAR(volume(surface) / before, 1, 1e-5);
  }
}

TEST(PreserveVolume, GivesBackWhatLaplacianTakes) {
  Surface surface = surface_of(sphere(3));
  const double before = volume(surface);
  Surface without = surface;
  smooth(without, "laplacian", {});
  EXPECT_LT(volume(without), 0.95 * before);
  smooth(surface, "laplacian", kKeepVolume);
  EXPECT_NEAR(volume(surface) / before, 1, 1e-5);
}

TEST(PreserveVolume, GivesBackEvenNearlyAll) {
  for (const std::int64_t iterations : {100, 1000}) {
    Surface surface = surface_of(sphere(3));
    const double before = volume(surface);
    EXPECT_THAT(smooth(surface, "laplacian", with(kKeepVolume, "iterations", iterations)), IsEmpty());
    EXPECT_NEAR(volume(surface) / before, 1, 1e-5) << iterations;
  }
}

TEST(PreserveVolume, KeepsEachComponentsOwn) {
  Shape shape = with_noise(sphere(3), 0.02);
  const Shape small = moved(scaled(with_noise(sphere(2), 0.05), 0.3), {1.7, 0, 0});
  const Index offset = static_cast<Index>(shape.positions.size());
  shape.positions.insert(shape.positions.end(), small.positions.begin(), small.positions.end());
  for (const auto& [a, b, c] : small.triangles)
    shape.triangles.push_back({a + offset, b + offset, c + offset});
  Surface surface = surface_of(shape);
  // A component's triangles follow its vertices, wherever the surface put them.
  std::vector<std::uint8_t> is_small(surface.mesh.positions.size());
  for (std::size_t v = offset; v < shape.positions.size(); ++v) is_small[surface.weld[v]] = 1;
  const auto volumes = [&] {
    std::array<double, 2> sums{};
    const auto each = volumes_of(surface);
    for (std::size_t t = 0; t < each.size(); ++t) sums[is_small[surface.mesh.triangles[t][0]]] += each[t];
    return sums;
  };
  const auto before = volumes();
  ASSERT_EQ(surface.mesh.triangles.size(), shape.triangles.size());
  smooth(surface, "laplacian", kKeepVolume);
  EXPECT_NEAR(volumes()[0] / before[0], 1, 1e-5);
  EXPECT_NEAR(volumes()[1] / before[1], 1, 1e-5);
}

TEST(PreserveVolume, DoesNotCareWhereTheMeshLies) {
  const Vec3d by = {1e4, -2e4, 3e4};
  const Shape closed = with_noise(sphere(3), 0.02), open = with_noise(grid(12), 0.2);
  for (const Shape& shape : {closed, open}) {
    Surface here = surface_of(shape), there = surface_of(moved(shape, by));
    smooth(here, "laplacian", kKeepVolume);
    smooth(there, "laplacian", kKeepVolume);
    const auto near = positions_of(here), far = positions_of(there);
    const double size = here.mesh.frame.scale();
    Vec3d shift;
    for (std::size_t v = 0; v < near.size(); ++v) {
      EXPECT_LT(length(far[v] - by - near[v]), 3e-6 * size);
      shift += (far[v] - by - near[v]) * (1.0 / static_cast<double>(near.size()));
    }
    EXPECT_LT(length(shift), 3e-7 * size);
  }
}

TEST(PreserveVolume, DoesNotMoveTheCentroidOfASphere) {
  const Shape shape = moved(sphere(3), {1e4, -2e4, 3e4});
  Surface surface = surface_of(shape);
  smooth(surface, "laplacian", kKeepVolume);
  Vec3d centroid;
  for (const Vec3d& p : positions_of(surface)) centroid += (p - Vec3d{1e4, -2e4, 3e4});
  EXPECT_LT(length(centroid * (1.0 / static_cast<double>(shape.positions.size()))), 1e-7);
}

/// The part of a sphere above z = -0.3.
Shape cap() {
  Shape shape = sphere(4), result;
  std::vector<Index> number(shape.positions.size(), kNone);
  for (const Triangle& t : shape.triangles) {
    Triangle kept;
    if (std::ranges::any_of(t, [&](Index v) { return shape.positions[v].z < -0.3; })) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      Index& known = number[t[c]];
      if (known == kNone) {
        known = static_cast<Index>(result.positions.size());
        result.positions.push_back(shape.positions[t[c]]);
      }
      kept[c] = known;
    }
    result.triangles.push_back(kept);
  }
  return result;
}

TEST(PreserveVolume, ClosesHolesByAFan) {
  for (const char* boundary : {"fixed", "free"}) {
    Surface surface = surface_of(cap());
    ASSERT_GT(surface.topology.boundary_edges, 0U);
    const double before = volume(surface);
    Surface without = surface;
    smooth(without, "laplacian", {{"boundary", boundary}});
    EXPECT_LT(volume(without), 0.98 * before);
    EXPECT_THAT(smooth(surface, "laplacian", with(kKeepVolume, "boundary", boundary)), IsEmpty());
    EXPECT_NEAR(volume(surface) / before, 1, 1e-5) << boundary;
  }
}

TEST(PreserveVolume, StaysWithinMaxDisplacement) {
  for (const double edges : {0.01, 0.1, 1.0}) {
    const Surface original = surface_of(with_noise(sphere(3), 0.02));
    Surface surface = original;
    EXPECT_THAT(smooth(surface, "laplacian", with(kKeepVolume, "max_displacement", edges)), IsEmpty());
    EXPECT_NEAR(volume(surface) / volume(original), 1, 1e-5) << edges;
    for (std::size_t v = 0; v < original.mesh.positions.size(); ++v) {
      const Vec3d way = to_double(surface.mesh.positions[v]) - to_double(original.mesh.positions[v]);
      EXPECT_LE(length(way), edges * original.mean_edge) << v;
    }
  }
}

TEST(PreserveVolume, ChangesNothingWhereNothingWasSmoothed) {
  Surface surface = surface_of(with_noise(sphere(2), 0.05));
  const auto before = surface.mesh.positions;
  EXPECT_THAT(smooth(surface, "laplacian", with(kKeepVolume, "iterations", std::int64_t{0})), IsEmpty());
  EXPECT_EQ(surface.mesh.positions, before);
}

TEST(PreserveVolume, SaysWhenItCannot) {
  Surface surface = surface_of(sphere(2));
  EXPECT_THAT(smooth(surface, "laplacian", with(kKeepVolume, "iterations", std::int64_t{100'000})),
              ElementsAre("volume_not_kept"));
}

}  // namespace
}  // namespace burnish
