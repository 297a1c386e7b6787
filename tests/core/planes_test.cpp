// Which surfaces are made of planes, and that settling on them harms no other.
#include "core/denoise/planes.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/measure/error.h"
#include "core/shape/noise.h"
#include "core/smooth/learned_normals.h"
#include "tests/support/compared.h"
#include "tests/support/procedural.h"

namespace burnish {
namespace {

using namespace burnish::testing;

/// A sheet whose cross-section goes on from x = 0 as `turn(x)` says, in radians: one unit long per step.
template <class Turn>
Shape sheet(int n, Turn&& turn) {
  Shape shape = grid(n);
  double x = 0, z = 0, angle = 0;
  for (int i = 0; i <= n; ++i) {
    for (int y = 0; y <= n; ++y)
      shape.positions[static_cast<std::size_t>(y * (n + 1) + i)] = {x, double(y), z};
    angle += turn(i);
    x += std::cos(angle), z += std::sin(angle);
  }
  return shape;
}

class Settling : public ::testing::Test {
 protected:
  /// From positions that are off by a little, as smoothing leaves them, with a scan that was off by more.
  void settle(const Shape& shape, double off, double scan_off = 0.2) {
    const RunControl run;
    const Surface surface = surface_of(with_noise(shape, scan_off));
    Faces faces(surface, FaceNeighbourhood::Vertices, run);
    // In the scan's frame.
    Buffer<SimdVec3> next, normals(faces.size());
    now_.clear();
    for (const Vec3d& p : with_noise(shape, off, 2).positions)
      now_.emplace_back(surface.mesh.frame.to_local(p));
    next = now_;
    before_ = now_;
    for (std::size_t f = 0; f < faces.size(); ++f) normals[f] = faces.measured(now_, f).normal;
    const std::vector<std::uint8_t> movable(now_.size(), 1);
    ASSERT_TRUE(settle_on_planes(faces, movable, 20, normals, now_, next));
    EXPECT_TRUE(std::ranges::equal(now_, next, [](SimdVec3 a, SimdVec3 b) { return a.vec3() == b.vec3(); }));
    result_ = shape;
    for (std::size_t v = 0; v < now_.size(); ++v) {
      result_.positions[v] = surface.mesh.frame.to_file(to_double(now_[v].vec3()));
    }
  }
  double moved() const {
    double most = 0;
    for (std::size_t v = 0; v < now_.size(); ++v) {
      most = std::max(most, static_cast<double>(length(now_[v] - before_[v])));
    }
    return most;
  }

  Buffer<SimdVec3> before_, now_;
  Shape result_;
};

TEST_F(Settling, PutsABoxOnItsSidesAndItsEdges) {
  const Shape box = scaled(cube(20), 10);  // edges of length 1
  settle(box, 0.02);
  double squares = 0;
  for (std::size_t v = 0; v < box.positions.size(); ++v) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(box.positions[v][axis]) != 10) continue;  // a side that the vertex is on
      const double off = result_.positions[v][axis] - box.positions[v][axis];
      squares += off * off;
    }
  }
  // Uniform noise up to .02 is .0115 root mean square.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(box.positions.size())), 0.002);
}

TEST_F(Settling, FindsPlanesThatMeetAtTenDegrees) {
  const Shape roof = sheet(20, [](int i) { return i == 9 ? 10 * std::numbers::pi / 180 : 0; });
  settle(roof, 0.01);
  double squares = 0;
  for (std::size_t v = 0; v < roof.positions.size(); ++v) {
    const Vec3d off = result_.positions[v] - roof.positions[v];
    const bool right = roof.positions[v].z > 0;
    const double tilt = right ? 10 * std::numbers::pi / 180 : 0;
    const double height = off.z * std::cos(tilt) - off.x * std::sin(tilt);
    squares += height * height;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(roof.positions.size())), 0.0025);  // of .0058
}

TEST_F(Settling, LeavesWhatIsCurvedAsItIs) {
  settle(sphere(5), 0);
  EXPECT_EQ(moved(), 0);
  // A cylinder of a radius of 60 edges: two neighbours differ by less than a degree.
  settle(sheet(40, [](int) { return 1.0 / 60; }), 0.005);
  EXPECT_EQ(moved(), 0);
  // The same between creases: a facet that is not quite flat.
  settle(sheet(40, [](int i) { return i == 19 ? 1.0 : 1.0 / 150; }), 0.005);
  EXPECT_EQ(moved(), 0);
}

TEST_F(Settling, LeavesAFilletBesideAPlaneAsItIs) {
  // Thirty-four edges of a plane, then a quarter of a circle of a radius of six edges at its end.
  const Shape bent = sheet(40, [](int i) { return i >= 34 ? 1.0 / 6 : 0; });
  settle(bent, 0);
  for (std::size_t v = 0; v < bent.positions.size(); ++v) {
    EXPECT_LT(length(result_.positions[v] - bent.positions[v]), 0.1) << v;
  }
}

TEST_F(Settling, TakesNoFewTrianglesForAPlane) {
  settle(scaled(cube(3), 1.5), 0.01);  // 18 triangles a side
  EXPECT_EQ(moved(), 0);
}

/// Seeds 11 and up were not trained on.
double ev_of(const std::string& name, std::int64_t plane_steps, unsigned threads = 1,
             std::vector<Vec3f>* positions = nullptr) {
  const Surface clean = surface_of(procedural_shape(name, 11, 12'000).shape);
  Surface surface = clean;
  EXPECT_TRUE(add_noise(surface, {.amplitude = 0.2, .seed = 5}));
  const Method& method = **find_method("learned_normals");
  EXPECT_TRUE(
      method.run(surface, *resolve_parameters(method, {{"plane_steps", plane_steps}}), {.threads = threads}));
  if (positions != nullptr) *positions = surface.mesh.positions;
  return measure_errors(surface, surface.mesh.positions, clean, clean.mesh.positions, true, {})->ev_over_edge;
}

TEST(PlaneSteps, HelpPlaneBodiesAndHarmNoOther) {
  for (const char* name : {"chamfered_box", "gem", "stairs"})
    EXPECT_LT(ev_of(name, 20), 0.8 * ev_of(name, 0)) << name;
  for (const char* name : {"bracket", "shaft", "cylinder", "gear", "blobs", "hair", "knot"}) {
    EXPECT_LT(ev_of(name, 20), 1.01 * ev_of(name, 0)) << name;
  }
}

TEST(PlaneSteps, GiveTheSameBytesOnAnyNumberOfThreads) {
  std::vector<Vec3f> one, two;
  ev_of("chamfered_box", 20, 1, &one);
  ev_of("chamfered_box", 20, 2, &two);
  EXPECT_TRUE(one == two);
}

}  // namespace
}  // namespace burnish
