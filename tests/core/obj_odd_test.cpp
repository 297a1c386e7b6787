// The expected outcome of each odd file: accepted with these counts and warnings, or refused with this cause.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/codec.h"
#include "core/smooth/registry.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace burnish::testing;

struct Row {
  const char* file;
  const char* outcome;  // "" = accepted, else the cause's code
  const char* says;     // part of the message, or the warnings' codes
  std::size_t vertices = 0, triangles = 0;
};

std::ostream& operator<<(std::ostream& out, const Row& row) { return out << row.file; }

class OddObj : public ::testing::TestWithParam<Row> {};

TEST_P(OddObj, HasItsExpectedOutcome) {
  const Row& row = GetParam();
  const auto path = real_mesh(std::string("odd/") + row.file);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the real meshes are not on this machine";
  const std::string text = read_file(path);
  auto decoded = decode(text, std::nullopt, {}, {});
  if (row.outcome[0] != '\0') {
    ASSERT_FALSE(decoded);
    EXPECT_EQ(cause_code(decoded.error().cause), row.outcome) << decoded.error().message;
    EXPECT_THAT(decoded.error().message, ::testing::HasSubstr(row.says));
    return;
  }
  ASSERT_TRUE(decoded) << decoded.error().message;
  const Document& document = **decoded;
  EXPECT_EQ(document.positions().size(), row.vertices);
  EXPECT_EQ(document.triangles().size(), row.triangles);
  auto surface = prepare_surface(document.positions(), document.triangles(), {});
  ASSERT_TRUE(surface);
  std::string codes;
  for (const Warning& warning : surface_warnings(
           *surface, [&](Index v) { return document.vertex_place(v); },
           [&](Index t) { return document.triangle_place(t); })) {
    codes += (codes.empty() ? "" : " ") + warning.code;
  }
  EXPECT_EQ(codes, row.says);
  for (const Method& method : methods()) {
    Surface copy = *surface;
    const auto values = resolve_parameters(method, {{"iterations", std::int64_t{50}}, {"boundary", "free"}});
    ASSERT_TRUE(method.run(copy, *values, {})) << method.name;
    for (const Vec3f& p : copy.mesh.positions) EXPECT_TRUE(is_finite(p)) << method.name;
  }
}

constexpr Row kRows[] = {
    {"cube_att.obj", "", "", 8, 12},
    {"cube_quads.obj", "", "", 8, 12},
    {"deg_faces.obj", "", "degenerate_triangles boundary_edges isolated_vertices", 6, 4},
    {"degenerate_mesh.obj", "", "welded_vertices degenerate_triangles isolated_vertices", 3, 1},
    {"empty.obj", "empty_mesh", "no vertex"},
    {"empty_name.obj", "", "boundary_edges", 3, 1},
    {"eof_test.obj", "", "boundary_edges", 3, 1},
    {"extra_vertex.obj", "", "boundary_edges isolated_vertices", 10, 3},
    {"inf_nan.obj", "non_finite_position", "vertex 1: coordinate x is \"inf\", not a finite number (line 1)"},
    {"malformed.obj", "index_out_of_range", "face 6 uses vertex 0; OBJ counts from 1 (line 28)"},
    {"malformed2.obj", "malformed_mesh", "face 1 has 0 corners; it needs at least 3 (line 23)"},
    {"mat_test.obj", "", "welded_vertices non_manifold_edges non_manifold_vertices", 3576, 1300},
    {"multiple_isolated_triangles.obj", "", "boundary_edges", 15, 5},
    {"multiple_tetrahedrons.obj", "", "", 20, 20},
    {"non_manifold_wrap.obj", "", "boundary_edges non_manifold_edges non_manifold_vertices", 10, 12},
    {"octagon.obj", "", "boundary_edges", 8, 6},
};

INSTANTIATE_TEST_SUITE_P(Files, OddObj, ::testing::ValuesIn(kRows), [](const auto& row) {
  std::string name = row.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

}  // namespace
}  // namespace burnish
