// What steps that sharpen must not do to a triangle, and that all else stays as they made it.
#include "core/denoise/turned.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "core/io/codec.h"
#include "core/shape/noise.h"
#include "core/smooth/learned_normals.h"
#include "tests/support/compared.h"
#include "tests/support/procedural.h"

namespace burnish {
namespace {

using namespace burnish::testing;

double degrees_between(SimdVec3 a, SimdVec3 b) {
  const SimdVec3 both = cross(a, b);
  return std::atan2(static_cast<double>(length(both)), static_cast<double>(dot(a, b))) * 180 /
         std::numbers::pi;
}

/// A sphere's own normals are predicted; noise of two strengths stands for before and after.
class Turned : public ::testing::Test {
 protected:
  static Buffer<SimdVec3> off_by(double amplitude, std::uint64_t seed) {
    Buffer<SimdVec3> positions;
    for (const Vec3d& p : with_noise(kShape, amplitude, seed).positions) {
      positions.emplace_back(kSurface.mesh.frame.to_local(p));
    }
    return positions;
  }
  SimdVec3 normal(const Buffer<SimdVec3>& positions, std::size_t f) const {
    return faces_.measured(positions, f).normal;
  }
  Buffer<SimdVec3> predicted() const {
    Buffer<SimdVec3> normals;
    const auto exact = off_by(0, 1);
    for (std::size_t f = 0; f < faces_.size(); ++f) normals.push_back(normal(exact, f));
    return normals;
  }
  std::size_t turned_too_far() const {
    std::size_t count = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const SimdVec3 is = normal(now_, f), was = normal(before_, f);
      const double off = degrees_between(is, predicted_[f]);
      bool far = off > 60.01 && off > degrees_between(was, predicted_[f]) + 0.01;
      for (const Index g : kSurface.topology.face_neighbours[f]) {
        const double edge = degrees_between(is, normal(now_, g));
        far = far || (degrees_between(was, is) > 20.01 && edge > 95.01 &&
                      edge > degrees_between(was, normal(before_, g)) + 0.01);
      }
      count += far ? 1U : 0U;
    }
    return count;
  }
  static bool equal(const Buffer<SimdVec3>& a, const Buffer<SimdVec3>& b) {
    return std::ranges::equal(a, b, [](SimdVec3 p, SimdVec3 q) { return p.vec3() == q.vec3(); });
  }

  inline static const Shape kShape = sphere(4);  // edges of about .07
  inline static const Surface kSurface = surface_of(kShape);
  RunControl run_{.threads = 3};
  Faces faces_{kSurface, FaceNeighbourhood::Vertices, run_};
  Buffer<SimdVec3> predicted_ = predicted(), before_ = off_by(0.006, 2), now_ = off_by(0.03, 3);
};

TEST_F(Turned, AreTakenBack) {
  ASSERT_GT(turned_too_far(), 100U);
  ASSERT_TRUE(take_back_turned(faces_, predicted_, before_, now_));
  EXPECT_EQ(turned_too_far(), 0U);
}

TEST_F(Turned, AreTakenBackToTheSameBitsByOneThread) {
  Buffer<SimdVec3> by_one = now_;
  const RunControl one{.threads = 1};
  ASSERT_TRUE(
      take_back_turned(Faces(kSurface, FaceNeighbourhood::Vertices, one), predicted_, before_, by_one));
  ASSERT_TRUE(take_back_turned(faces_, predicted_, before_, now_));
  EXPECT_TRUE(equal(now_, by_one));
}

TEST_F(Turned, AreNotThoseThatTurnALittle) {
  now_ = off_by(0.006, 3);
  const auto made = now_;
  ASSERT_TRUE(take_back_turned(faces_, predicted_, before_, now_));
  EXPECT_TRUE(equal(now_, made));
}

TEST_F(Turned, GoBackHalfTheWayWhereThatWillDo) {
  now_ = before_;
  const SimdVec3 out = off_by(0, 1)[0];
  now_[0] = before_[0] + out * (0.12F / length(out));  // a spike: its edges are sharp, half of it has none
  const auto made = now_;
  ASSERT_GT(turned_too_far(), 0U);
  ASSERT_TRUE(take_back_turned(faces_, predicted_, before_, now_));
  EXPECT_EQ(turned_too_far(), 0U);
  EXPECT_GT(length(now_[0] - before_[0]), 0.2F * length(made[0] - before_[0]));
  now_[0] = before_[0];
  EXPECT_TRUE(equal(now_, before_));
}

TEST_F(Turned, HearAStop) {
  std::stop_source stop;
  stop.request_stop();
  const RunControl stopped{.stop = stop.get_token()};
  EXPECT_FALSE(
      take_back_turned(Faces(kSurface, FaceNeighbourhood::Vertices, stopped), predicted_, before_, now_));
}

TEST_F(Turned, NoTriangleFlipsThatAgreedInTheScan) {
  const auto scan = off_by(0, 1);
  const auto flipped = [&] {
    std::size_t count = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      count += dot(normal(now_, f), predicted_[f]) < 0 ? 1U : 0U;
    return count;
  };
  now_ = off_by(0.06, 3);
  ASSERT_GT(flipped(), 100U);
  ASSERT_TRUE(take_back_flipped(faces_, predicted_, now_));
  EXPECT_EQ(flipped(), 0U);
}

Shape shape_of_file(const std::string& name) {
  const auto document = decode(read_file(real_mesh(name)), Format::Obj, {}, {});
  const auto positions = (*document)->positions();
  const auto triangles = (*document)->triangles();
  return {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
}

Vec3d normal_of(const Shape& shape, std::size_t f) {
  const auto& [a, b, c] = shape.triangles[f];
  return cross(shape.positions[b] - shape.positions[a], shape.positions[c] - shape.positions[a]);
}

Shape denoised(const Shape& scan) {
  return smoothed(scan,
                  [](Surface& surface, const IterationOptions& options) {
                    return smooth_learned_normals(surface, {}, options, {});
                  },
                  {.iterations = kLearnedStages});
}

/// Triangles turned against the original that were not in the scan: 2 and 45 when facets and planes went
/// unchecked, of which 22 are against it without them; in ten places the original itself is folded over.
TEST(LearnedNormals, SeldomTurnATriangleAgainstTheOriginal) {
  for (const auto& [name, most] : {std::pair{"Block0.4", 0U}, {"SharpSphere0.3", 26U}}) {
    const std::string folder = std::string("pairs/") + name;
    if (read_file(real_mesh(folder + "/Noisy.obj")).empty()) GTEST_SKIP() << "no " << folder;
    const Shape original = shape_of_file(folder + "/Original.obj"),
                scan = shape_of_file(folder + "/Noisy.obj");
    ASSERT_EQ(original.triangles, scan.triangles);
    const Shape result = denoised(scan);
    unsigned turned = 0;
    for (std::size_t f = 0; f < scan.triangles.size(); ++f) {
      const Vec3d truth = normal_of(original, f);
      turned += dot(normal_of(result, f), truth) < 0 && dot(normal_of(scan, f), truth) >= 0 ? 1U : 0U;
    }
    EXPECT_LE(turned, most) << name;
  }
}

/// Triangles that lie with those around them in `scan` and against them in `result`: what flipped means to
/// whoever has neither the original nor the predicted normals.
unsigned folded_over(const Shape& scan, const Shape& result) {
  std::vector<std::vector<std::size_t>> at(scan.positions.size());
  for (std::size_t f = 0; f < scan.triangles.size(); ++f)
    for (const Index v : scan.triangles[f]) at[v].push_back(f);
  const auto lies_with_its_ring = [&at](const Shape& shape, std::size_t f) {
    std::set<std::size_t> ring;
    for (const Index v : shape.triangles[f]) ring.insert(at[v].begin(), at[v].end());
    ring.erase(f);
    Vec3d sum{};
    for (const std::size_t g : ring) sum = sum + normal_of(shape, g);
    return dot(normal_of(shape, f), sum) > 0;
  };
  unsigned count = 0;
  for (std::size_t f = 0; f < scan.triangles.size(); ++f)
    count += lies_with_its_ring(scan, f) && !lies_with_its_ring(result, f) ? 1U : 0U;
  return count;
}

/// Bunny0.2 2, Fandisk0.3 1, Fandisk0.7 2 and SharpSphere0.3 15 when nothing is taken back. Of the 13, nine
/// are folded over in the original too, whose creases are a few triangles apart.
TEST(LearnedNormals, FoldNoTriangleOver) {
  for (const auto& [name, most] : {std::pair{"Block0.4", 0U},
                                   {"Bunny0.2", 0U},
                                   {"Fandisk0.3", 0U},
                                   {"Fandisk0.7", 0U},
                                   {"SharpSphere0.3", 13U}}) {
    const std::string file = std::string("pairs/") + name + "/Noisy.obj";
    if (read_file(real_mesh(file)).empty()) GTEST_SKIP() << "no " << file;
    const Shape scan = shape_of_file(file);
    EXPECT_LE(folded_over(scan, denoised(scan)), most) << name;
  }
}

/// In the frame of its surface.
Shape noisy(Shape shape, const NoiseOptions& options) {
  Surface surface = surface_of(shape);
  EXPECT_TRUE(add_noise(surface, options));
  std::ranges::transform(surface.mesh.positions, shape.positions.begin(), [](const auto& p) {
    return Vec3d{p.x, p.y, p.z};
  });
  return shape;
}

/// 3, 1, 0 and 4 when nothing is taken back; of some 6000 triangles noise folded over 700 to 900.
TEST(LearnedNormals, FoldNoTriangleOverUnderMuchNoise) {
  for (const char* name : {"stairs", "bracket", "cone", "relief"}) {
    const Shape scan = noisy(procedural_shape(name, 11, 6000).shape, {.amplitude = 0.7, .seed = 5});
    const Shape result = denoised(scan);
    EXPECT_EQ(folded_over(scan, result), 0U) << name;
    EXPECT_GT(folded_over(result, scan), 500U) << name;
  }
}

/// Triangles turned against the clean shape that were not in the scan.
unsigned turned_when(const ConstraintOptions& constraints, NoiseDirection direction, double amplitude) {
  const Surface clean = surface_of(procedural_shape("shaft", 11, 6000).shape);
  Surface scan = clean;
  EXPECT_TRUE(add_noise(scan, {.direction = direction, .amplitude = amplitude, .seed = 5}));
  Surface result = scan;
  IterationOptions options{.iterations = kLearnedStages, .constraints = constraints};
  options.constraints.max_displacement *= scan.mean_edge;
  EXPECT_TRUE(smooth_learned_normals(result, {}, options, {}));
  const Faces faces(clean, FaceNeighbourhood::Vertices, {});
  const auto normals = [&](const Surface& surface) {
    const Buffer<SimdVec3> positions(surface.mesh.positions.begin(), surface.mesh.positions.end());
    std::vector<SimdVec3> all;
    for (std::size_t f = 0; f < faces.size(); ++f) all.push_back(faces.measured(positions, f).normal);
    return all;
  };
  const auto truth = normals(clean), before = normals(scan), after = normals(result);
  unsigned turned = 0;
  for (std::size_t f = 0; f < truth.size(); ++f)
    turned += dot(after[f], truth[f]) < 0 && dot(before[f], truth[f]) >= 0 ? 1U : 0U;
  return turned;
}

/// 11 and 75 when the constraints come after what is taken back, 21 and 77 when nothing is.
TEST(LearnedNormals, TurnNoMoreTrianglesForWhatACallerAsks) {
  EXPECT_LE(turned_when({.lock_features = 50}, NoiseDirection::Normal, 0.5), 10U);
  EXPECT_LE(turned_when({.max_displacement = 0.4}, NoiseDirection::Random, 0.7), 55U);
}

TEST(Iterate, FinishesOnWhatItWritesAfterConstraintsAndVolume) {
  Surface surface = surface_of(with_noise(sphere(2), 0.05));
  const auto home = surface.mesh.positions;
  const double limit = 0.02;
  const Constraints constraints(surface, {.max_displacement = limit});
  float farthest = 0;
  const auto push = [](auto from, auto to, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) to[v] = from[v] * 1.5F;
  };
  const auto take_first_home = [&](std::span<SimdVec3> positions) {
    for (std::size_t v = 0; v < home.size(); ++v)
      farthest = std::max(farthest, length(positions[v] - SimdVec3(home[v])));
    positions[0] = SimdVec3(home[0]);
    return true;
  };
  ASSERT_TRUE(iterate(surface, constraints, {.iterations = 2, .preserve_volume = true}, {},
                      {.move = push, .finish = take_first_home}));
  EXPECT_LE(farthest, limit);
  EXPECT_TRUE(surface.mesh.positions[0] == home[0]);
  EXPECT_FALSE(surface.mesh.positions[1] == home[1]);
}

TEST(Iterate, LeavesTheSurfaceAloneWhenItsFinishIsStopped) {
  Surface surface = surface_of(sphere(2));
  const auto home = surface.mesh.positions;
  std::stop_source stop;
  const auto push = [](auto from, auto to, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) to[v] = from[v] * 1.5F;
  };
  const auto stopped = [&](std::span<SimdVec3>) { return !stop.request_stop(); };
  const auto outcome = iterate(surface, Constraints(surface, {}), {.iterations = 1},
                               {.stop = stop.get_token()}, {.move = push, .finish = stopped});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().cause, Cause::Cancelled);
  EXPECT_TRUE(surface.mesh.positions == home);
}

}  // namespace
}  // namespace burnish
