// What every method of the registry owes its users, whatever its parameters.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/io/text_number.h"
#include "core/smooth/registry.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace burnish::testing;
using Given = std::map<std::string, ParameterValue>;

/// All methods by their defaults, and adaptive in each of its variants.
struct Variant {
  std::string method;
  Given given;
};

std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const Method& method : methods()) {
    all.push_back({method.name, {}});
    for (const ParameterSpec& spec : method.parameters) {
      for (std::size_t c = 1; c < spec.choices.size(); ++c)
        all.push_back({method.name, {{spec.name, spec.choices[c]}}});
    }
  }
  return all;
}

std::ostream& operator<<(std::ostream& out, const Variant& v) {
  out << v.method;
  for (const auto& [name, value] : v.given) out << ' ' << name << '=' << std::get<std::string>(value);
  return out;
}

class EveryMethod : public ::testing::TestWithParam<Variant> {
 protected:
  SmoothOutcome run(Surface& surface, Given more = {}, const RunControl& control = {}) {
    const Method& method = **find_method(GetParam().method);
    more.insert(GetParam().given.begin(), GetParam().given.end());
    auto outcome = method.run(surface, *resolve_parameters(method, more), control);
    EXPECT_TRUE(outcome);
    return outcome ? *outcome : SmoothOutcome{};
  }

  Shape smoothed(const Shape& shape, const Given& more = {}) {
    Surface surface = surface_of(shape);
    run(surface, more);
    Shape result = shape;
    for (std::size_t v = 0; v < shape.positions.size(); ++v) {
      result.positions[v] = surface.mesh.frame.to_file(to_double(surface.mesh.positions[surface.weld[v]]));
    }
    return result;
  }

  static double distance(const Shape& a, const Shape& b) {
    double worst = 0;
    for (std::size_t v = 0; v < a.positions.size(); ++v)
      worst = std::max(worst, length(a.positions[v] - b.positions[v]));
    return worst;
  }
};

TEST_P(EveryMethod, LeavesAFlatMeshFlat) {
  const Shape result = smoothed(grid(10));
  for (const Vec3d& p : result.positions) EXPECT_NEAR(p.z, 0, 1e-6);
}

TEST_P(EveryMethod, DoesNothingInNoIterations) {
  Surface surface = surface_of(with_noise(sphere(2), 0.05));
  const auto before = surface.mesh.positions;
  EXPECT_EQ(run(surface, {{"iterations", std::int64_t{0}}}).iterations, 0U);
  EXPECT_EQ(surface.mesh.positions, before);
}

TEST_P(EveryMethod, MovesNoisyVertices) {
  Surface surface = surface_of(with_noise(sphere(2), 0.05));
  const auto before = surface.mesh.positions;
  const auto defaults = resolve_parameters(**find_method(GetParam().method), {});
  EXPECT_EQ(run(surface).iterations, defaults->integer("iterations"));
  std::size_t moved = 0;
  for (std::size_t v = 0; v < before.size(); ++v) moved += !(surface.mesh.positions[v] == before[v]);
  EXPECT_EQ(moved, before.size());
}

TEST_P(EveryMethod, CommutesWithRigidMotion) {
  const Shape shape = with_noise(cube(6), 0.06);
  // A median chooses; where two neighbours are equally good, rounding does, and in the end it shows.
  const Given few = {{"iterations", std::int64_t{GetParam().method == "median_normals" ? 3 : 20}}};
  const Shape one = rotated(moved(smoothed(shape, few), {10, -20, 30}));
  const Shape other = smoothed(rotated(moved(shape, {10, -20, 30})), few);
  EXPECT_LT(distance(one, other), 2e-4);
}

TEST_P(EveryMethod, CommutesExactlyWithScalingByPowersOfTwo) {
  const Shape shape = with_noise(sphere(2), 0.05);
  Surface one = surface_of(shape);
  run(one);
  for (const int exponent : {-100, -3, 1, 40}) {
    Surface other = surface_of(scaled(shape, std::ldexp(1.0, exponent)));
    run(other);
    EXPECT_EQ(one.mesh.positions, other.mesh.positions) << exponent;
  }
}

TEST_P(EveryMethod, CommutesWithAnyOtherScale) {
  const Shape shape = with_noise(sphere(2), 0.05);
  EXPECT_LT(distance(scaled(smoothed(shape), 1e3), smoothed(scaled(shape, 1e3))), 1e-2);
}

TEST_P(EveryMethod, CommutesWithTheOrderOfVerticesAndTriangles) {
  const Shape shape = with_noise(sphere(2), 0.05);
  const auto order = shuffled(shape.positions.size());
  Shape other = with_vertex_order(shape, order);
  std::reverse(other.triangles.begin(), other.triangles.end());
  for (Triangle& t : other.triangles) t = {t[1], t[2], t[0]};
  EXPECT_LT(distance(with_vertex_order(smoothed(shape), order), smoothed(other)), 1e-5);
}

TEST_P(EveryMethod, GivesTheSameBytesForAnyNumberOfThreads) {
  const Shape shape = with_noise(sphere(5), 0.01);      // 10242 vertices: several blocks
  const Given few = {{"iterations", std::int64_t{2}}};  // what differs differs at once
  Surface one = surface_of(shape);
  run(one, few, {.threads = 1});
  for (const unsigned threads : {2U, 5U, 0U}) {
    Surface other = surface_of(shape);
    run(other, few, {.threads = threads});
    EXPECT_EQ(one.mesh.positions, other.mesh.positions) << threads;
  }
}

TEST_P(EveryMethod, StaysFiniteForAThousandIterations) {
  const std::int64_t iterations = GetParam().given.empty() ? 1000 : 100;  // variants: fewer, some are slow
  for (const Shape& shape :
       {with_noise(sphere(2), 0.3), with_noise(cube(3), 0.5), with_noise(grid(6), 0.9)}) {
    Surface surface = surface_of(shape);
    run(surface, {{"iterations", iterations}});
    for (const Vec3f& p : surface.mesh.positions) ASSERT_TRUE(is_finite(p));
  }
}

TEST_P(EveryMethod, StaysFiniteAtTheEndsOfItsRanges) {
  const Method& method = **find_method(GetParam().method);
  for (const ParameterSpec& spec : method.parameters) {
    if (spec.kind != ParameterKind::Number) continue;
    for (const double value : {spec.minimum, spec.maximum}) {
      Surface surface = surface_of(with_noise(sphere(2), 0.3));
      run(surface, {{"iterations", std::int64_t{60}}, {spec.name, value}});
      for (const Vec3f& p : surface.mesh.positions) ASSERT_TRUE(is_finite(p)) << spec.name << ' ' << value;
    }
  }
}

TEST_P(EveryMethod, KeepsAFixedBoundaryToTheBit) {
  const bool free = GetParam().given.contains("boundary");
  Surface surface = surface_of(with_noise(grid(8), 0.2));
  const auto before = surface.mesh.positions;
  run(surface);
  bool rim_moved = false;
  for (Index v = 0; v < before.size(); ++v) {
    if (!surface.topology.has(v, kBoundaryVertex)) continue;
    if (free) {
      rim_moved = rim_moved || !(surface.mesh.positions[v] == before[v]);
    } else {
      EXPECT_EQ(surface.mesh.positions[v], before[v]);
    }
  }
  EXPECT_EQ(rim_moved, free);
}

TEST_P(EveryMethod, KeepsIsolatedAndNonManifoldVerticesToTheBit) {
  Shape shape = with_noise(sphere(2), 0.05);
  const Index apex = static_cast<Index>(shape.positions.size());
  shape.positions.push_back({0, 0, 3});  // a fin on the edge of the first triangle
  shape.positions.push_back({7, 7, 7});  // in no triangle
  const auto [a, b, c] = shape.triangles[0];
  shape.triangles.push_back({a, b, apex});
  Surface surface = surface_of(shape);
  const auto before = surface.mesh.positions;
  run(surface, {{"boundary", "free"}});
  for (const Index v : {a, b, apex + 1}) EXPECT_EQ(surface.mesh.positions[v], before[v]) << v;
  EXPECT_NE(surface.mesh.positions[c], before[c]);
}

TEST_P(EveryMethod, KeepsEveryVertexWithinItsMaxDisplacement) {
  struct Row {
    const char* unit;
    double bound;
  };
  const Shape shape = with_noise(scaled(sphere(3), 40), 2.5);
  Surface original = surface_of(shape);
  const double unit = original.mesh.frame.scale();
  for (const Row& row : {Row{"edges", 0.1}, Row{"edges", 1e-9}, Row{"mesh", 0.25}, Row{"mesh", 1e-3}}) {
    Surface surface = original;
    run(surface, {{"max_displacement", row.bound}, {"max_displacement_unit", std::string(row.unit)}});
    const double bound = row.bound * (row.unit == std::string("edges") ? original.mean_edge * unit : 1);
    const double text = DecimalWriter(surface.mesh.frame).largest_error();
    double farthest = 0;
    for (std::size_t v = 0; v < surface.mesh.positions.size(); ++v) {
      const double way =
          length(to_double(surface.mesh.positions[v]) - to_double(original.mesh.positions[v])) * unit;
      farthest = std::max(farthest, way);
      ASSERT_LE(way + (way > 0 ? text : 0), bound) << row.unit << ' ' << row.bound;
    }
    if (row.bound > 1e-2) {
      EXPECT_GT(farthest, 0.9 * bound);
    }
  }
}

TEST_P(EveryMethod, StopsBeforeAndDuringItsRunAndLeavesTheMeshAsItWas) {
  const Method& method = **find_method(GetParam().method);
  const Shape shape = with_noise(sphere(3), 0.02);
  for (const int stop_at : {0, 1}) {
    std::stop_source source;
    if (stop_at == 0) source.request_stop();
    int reports = 0;
    const RunControl control{.stop = source.get_token(), .progress = [&](double fraction) {
                               EXPECT_GT(fraction, 0);
                               EXPECT_LE(fraction, 1);
                               if (++reports == stop_at) source.request_stop();
                             }};
    Surface surface = surface_of(shape);
    const auto before = surface.mesh.positions;
    const auto outcome = method.run(surface, *resolve_parameters(method, GetParam().given), control);
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().cause, Cause::Cancelled);
    EXPECT_EQ(surface.mesh.positions, before);
    EXPECT_EQ(reports, stop_at);
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryMethod, ::testing::ValuesIn(variants()), [](const auto& row) {
  std::string name = row.param.method;
  for (const auto& [key, value] : row.param.given) name += '_' + key + '_' + std::get<std::string>(value);
  return name;
});

TEST(Taubin, KeepsTheVolumeThatLaplacianLoses) {
  const auto volume = [](const Surface& s) {
    double sum = 0;
    for (const auto& [a, b, c] : s.mesh.triangles) {
      const auto& p = s.mesh.positions;
      sum += dot(to_double(p[a]), cross(to_double(p[b]), to_double(p[c]))) / 6;
    }
    return sum;
  };
  const Shape shape = sphere(3);
  const auto change = [&](const char* name) {
    Surface surface = surface_of(shape);
    const double before = volume(surface);
    const Method& method = **find_method(name);
    EXPECT_TRUE(method.run(surface, *resolve_parameters(method, {}), {}));
    return volume(surface) / before - 1;
  };
  EXPECT_LT(change("laplacian"), -0.05);
  EXPECT_LT(std::abs(change("taubin")), 0.02);
}

/// How far apart the results are when every third triangle winds the other way.
float apart_by_winding(const char* name) {
  const Shape shape = with_noise(sphere(3), 0.02);
  Shape mixed = shape;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  Surface one = surface_of(shape), other = surface_of(mixed);
  const Method& method = *find_method(name).value();
  const auto values = resolve_parameters(method, {});
  EXPECT_TRUE(method.run(one, *values, {}));
  EXPECT_TRUE(method.run(other, *values, {}));
  float farthest = 0;
  for (std::size_t v = 0; v < one.mesh.positions.size(); ++v)
    farthest = std::max(farthest, length(one.mesh.positions[v] - other.mesh.positions[v]));
  return farthest;
}

TEST(Adaptive, SmoothsAcrossTrianglesThatWindTheOtherWay) { EXPECT_LT(apart_by_winding("adaptive"), 1e-4F); }

/// Its filters choose the most even patch around a face: rounding may tip the choice. An edge has .15 here.
TEST(Auto, SmoothsAcrossTrianglesThatWindTheOtherWay) { EXPECT_LT(apart_by_winding("auto"), 4e-4F); }

}  // namespace
}  // namespace burnish
