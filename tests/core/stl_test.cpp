#include "core/io/stl.h"

#include <gmock/gmock.h>

#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "tests/core/format_fixture.h"

namespace burnish::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kText =
    "solid  a part \r\n"
    " facet normal 0 0 -1\r\n"
    "  outer loop\r\n"
    "    vertex 0.0 0 0\r\n"
    "    vertex 0 1.0e0 0\r\n"
    "    vertex 1 0 0\r\n"
    "  endloop\r\n"
    " endfacet\r\n"
    "FACET NORMAL 0 0 0 OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 0 1 ENDLOOP ENDFACET\r\n"
    "endsolid\r\n"
    "solid another\r\n"
    "facet normal -1 0 0 outer loop vertex -0 0 0\tvertex 0 0 1 vertex 0 1 0 endloop endfacet\r\n"
    "facet normal nan nan nan outer loop vertex 1 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet";

std::string binary(const Shape& shape, const std::string& header, bool attributes) {
  std::string bytes = header;
  bytes.resize(80, '\0');
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(shape.triangles.size()));
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    for (int axis = 0; axis < 3; ++axis) put(axis == 2 ? 1.0F : 0.0F);
    for (const Index v : shape.triangles[t]) {
      for (std::size_t axis = 0; axis < 3; ++axis) put(static_cast<float>(shape.positions[v][axis]));
    }
    put(static_cast<std::uint16_t>(attributes ? 1000 + t : 0));
  }
  return bytes;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

TEST(Stl, OfTextWeldsEqualPositionsInTheOrderOfTheirFirstUse) {
  const LoadedFile file(kText);
  EXPECT_EQ(file.document->format(), Format::Stl);
  EXPECT_THAT(file.document->positions(),
              ElementsAre(Vec3d{0, 0, 0}, Vec3d{0, 1, 0}, Vec3d{1, 0, 0}, Vec3d{0, 0, 1}));
  EXPECT_THAT(file.document->triangles(),
              ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 3, 1}, Triangle{2, 1, 3}));
  EXPECT_EQ(file.surface.topology.boundary_edges, 0U);
  EXPECT_EQ(file.written(), kText);
}

TEST(Stl, OfTextChangesOnlyMovedVerticesAndTheNormalsOfTheirFacets) {
  LoadedFile file(kText);
  file.move(3, {0, 0, 1});
  const auto was = lines(kText), is = lines(file.written());
  ASSERT_EQ(was.size(), is.size());
  for (std::size_t i = 0; i < was.size(); ++i)
    EXPECT_EQ(was[i] != is[i], i == 8 || i == 11 || i == 12) << was[i];
  EXPECT_EQ(is[8],
            "FACET NORMAL 0 0 0 OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0.00000000 0.00000000 2.00000000 "
            "ENDLOOP ENDFACET\r");
  EXPECT_EQ(is[11],
            "facet normal -1.000000 0.000000 0.000000 outer loop vertex -0 0 0\tvertex 0.00000000 0.00000000 "
            "2.00000000 vertex 0 1 0 endloop endfacet\r");
  EXPECT_EQ(is[12],
            "facet normal 0.666667 0.666667 0.333333 outer loop vertex 1 0 0 vertex 0 1 0 vertex 0.00000000 "
            "0.00000000 2.00000000 endloop endfacet");
}

TEST(Stl, OfBinaryKeepsHeaderAttributesAndWhatStandsBehind) {
  for (const char* behind : {"", "\n", "the end"}) {
    const LoadedFile file(binary(cube(2), "solid cube, but binary; COLOR=abcd", true) + behind);
    EXPECT_EQ(file.document->positions().size(), cube(2).positions.size());
    EXPECT_EQ(file.written(), file.bytes);
  }
}

TEST(Stl, OfBinaryChangesOnlyTheFloatsOfMovedVerticesAndTheNormalsOfTheirFacets) {
  LoadedFile file(binary(cube(2), "a cube", true));
  file.move(0, {0.125, 0, 0});
  const std::string written = file.written();
  ASSERT_EQ(written.size(), file.bytes.size());
  std::set<std::size_t> facets;
  for (std::size_t i = 0; i < written.size(); ++i) {
    if (written[i] == file.bytes[i]) continue;
    ASSERT_GE(i, 84U);
    EXPECT_LT((i - 84) % 50, 48U) << "an attribute byte";
    facets.insert((i - 84) / 50);
  }
  for (std::size_t t = 0; t < file.document->triangles().size(); ++t) {
    const Triangle& triangle = file.document->triangles()[t];
    const bool cites = triangle[0] == 0 || triangle[1] == 0 || triangle[2] == 0;
    EXPECT_EQ(facets.count(t) == 1, cites) << t;
  }
}

TEST(Stl, StaysWatertight) {
  for (const bool text : {false, true}) {
    LoadedFile file(text ? LoadedFile(to_obj(sphere(3))).written(Format::Stl)
                         : binary(sphere(3), "a sphere", false));
    if (text) {  // as text, from our own binary
      std::string bytes = "solid s\n";
      for (const Triangle& t : file.document->triangles()) {
        bytes += "facet normal 0 0 1\nouter loop\n";
        for (const Index v : t) {
          const Vec3d& p = file.document->positions()[v];
          bytes +=
              "vertex " + std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + '\n';
        }
        bytes += "endloop\nendfacet\n";
      }
      file = LoadedFile(bytes + "endsolid s\n");
    }
    file.move_all();
    const LoadedFile again(file.written());
    EXPECT_EQ(again.document->positions().size(), sphere(3).positions.size());
    EXPECT_EQ(again.surface.topology.boundary_edges, 0U);
    EXPECT_TRUE(std::ranges::equal(again.document->triangles(), file.document->triangles()));
    expect_positions(*again.document, file.moved(), 1e-6);
  }
}

TEST(Stl, SaysWhatIsWrongAndWhere) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const std::string cube_bytes = binary(cube(1), "", false);
  std::string nan = cube_bytes, many = cube_bytes, none = cube_bytes.substr(0, 84);
  const float not_a_number = NAN;
  std::memcpy(&nan[84 + 50 + 12 + 4], &not_a_number, 4);
  const std::uint32_t billion = 1'000'000'000;
  std::memcpy(&many[80], &billion, 4);
  std::memset(&none[80], 0, 4);
  struct Row {
    std::string bytes;
    Cause cause;
    const char* message;
  };
  const Row rows[] = {
      {"solid\nendsolid\n", Cause::EmptyMesh, "no facet"},
      {"solid a\n" + facet + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 x 0\n",
       Cause::MalformedMesh, "facet 2, vertex 2: coordinate y is not a number but \"x\" (line 12)"},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex inf 0 0\n", Cause::NonFinitePosition,
       "facet 1, vertex 1: coordinate x is \"inf\", not a finite number (line 4)"},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 1 1\n",
       Cause::MalformedMesh, "facet 1: expected \"endloop\" instead of \"vertex\" (line 7)"},
      {"solid a\nfacet normal 0 0 1\nouter", Cause::MalformedMesh, "the file ends in facet 1"},
      {"solid a\nface 1 2 3\n", Cause::MalformedMesh,
       "expected \"facet\" or \"endsolid\" instead of \"face\" (line 2)"},
      {cube_bytes.substr(0, 300), Cause::MalformedMesh,
       "declares 12 facets, which are 684 bytes; it has 300"},
      {cube_bytes.substr(0, 60), Cause::MalformedMesh, "at least 84 bytes; this file has 60"},
      {nan, Cause::NonFinitePosition, "facet 2, vertex 1: coordinate y is not a finite number (byte 150)"},
      {many, Cause::TooLarge, "(max-triangles)"},
      {none, Cause::EmptyMesh, "no facet"},
  };
  for (const Row& row : rows) {
    const Error error = error_of(row.bytes, Format::Stl);
    EXPECT_EQ(error.cause, row.cause) << error.message;
    EXPECT_THAT(error.message, HasSubstr(row.message));
  }
  const Limits any{.max_triangles = ~std::uint64_t{0}};
  EXPECT_EQ(error_of(many, Format::Stl, any).cause, Cause::MalformedMesh)
      << "nothing is allocated for a count alone";
}

TEST(Stl, EveryPrefixIsAnErrorOrAMesh) {
  expect_prefixes_survive(kText, Format::Stl);
  expect_prefixes_survive(binary(cube(1), "solid", true), Format::Stl);
}

TEST(Stl, LimitsAreKept) {
  const std::string bytes = binary(cube(1), "", false);
  EXPECT_THAT(error_of(bytes, Format::Stl, {.max_triangles = 11}).message, HasSubstr("(max-triangles)"));
  EXPECT_THAT(error_of(bytes, Format::Stl, {.max_vertices = 7}).message, HasSubstr("(max-vertices)"));
  EXPECT_EQ(error_of(bytes, Format::Stl, {.max_vertices = 8, .max_triangles = 12}).message, "accepted");
  EXPECT_THAT(error_of(kText, Format::Stl, {.max_triangles = 3}).message, HasSubstr("(max-triangles)"));
  EXPECT_THAT(error_of(kText, Format::Stl, {.max_line_bytes = 30}).message,
              HasSubstr("(max-line-bytes) (line 9)"));
}

TEST(Stl, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  for (const std::string& bytes : {std::string(kText), binary(cube(1), "", false)})
    EXPECT_EQ(error_of(bytes, Format::Stl, {}, {.stop = stop.get_token()}).cause, Cause::Cancelled);
}

TEST(Stl, NamesPlaces) {
  const LoadedFile text(kText), bytes(binary(cube(1), "", false));
  EXPECT_EQ(text.document->triangle_place(2), "facet 3 (line 12)");
  EXPECT_EQ(text.document->vertex_place(3), "vertex 3 of facet 2 (line 9)");
  EXPECT_EQ(bytes.document->triangle_place(1), "facet 2 (byte 134)");
}

}  // namespace
}  // namespace burnish::testing
