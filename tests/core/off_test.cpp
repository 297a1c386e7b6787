#include "core/io/off.h"

#include <gmock/gmock.h>

#include <sstream>

#include "tests/core/format_fixture.h"

namespace burnish::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kScan =
    "# by hand\r\n"
    "COFF # with colours\r\n"
    "\r\n"
    "5 3 0   # counts\r\n"
    "0 0 0 255 0 0 255\r\n"
    "  1.00 0 0  0 255 0 255 # green\r\n"
    "# between\r\n"
    "1 1 0.25 0 0 255 255\r\n"
    "0 1 0 51 51 51 255\r\n"
    "0.5 0.5 1 255 255 255 0\r\n"
    "4 0 1 2 3  0.5 0.5 0.5\r\n"
    "3 0 1 4 # no colour\r\n"
    "3  2 3 4 7";

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

TEST(Off, ReadsVerticesFacesAndPolygons) {
  const LoadedFile file(kScan);
  EXPECT_EQ(file.document->format(), Format::Off);
  EXPECT_EQ(file.document->positions().size(), 5U);
  EXPECT_EQ(file.document->positions()[2], (Vec3d{1, 1, 0.25}));
  EXPECT_THAT(file.document->triangles(),
              ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 1, 4}, Triangle{2, 3, 4}));
  EXPECT_EQ(file.written(), kScan);
}

TEST(Off, ChangesOnlyTheNumbersOfMovedVertices) {
  LoadedFile file(kScan);
  file.move(1, {0, 0, 0.25});
  const auto was = lines(kScan), is = lines(file.written());
  ASSERT_EQ(was.size(), is.size());
  for (std::size_t i = 0; i < was.size(); ++i) EXPECT_EQ(was[i] != is[i], i == 5) << was[i];
  EXPECT_EQ(is[5], "  1.00000000 0.00000000 0.25000000  0 255 0 255 # green\r");
}

TEST(Off, RecomputesTheNormalsOfNoff) {
  for (const std::string keyword : {"NOFF", "CNOFF", "STCNOFF"}) {
    LoadedFile file(keyword + "\n3 1 0\n0 0 0 0 0 1 9 8 7\n1 0 0 0 0 1 9 8 7\n0 1 0 0 0 1 9 8 7\n3 0 1 2\n");
    file.move(1, {0, 0, 1});  // the triangle now leans by 45 degrees
    const auto is = lines(file.written());
    EXPECT_EQ(is[2], "0 0 0 -0.707107 0.000000 0.707107 9 8 7");
    EXPECT_EQ(is[3], "1.00000000 0.00000000 1.00000000 -0.707107 0.000000 0.707107 9 8 7");
  }
}

TEST(Off, CountsMayFollowTheKeywordAndEdgesMayBeLeftOut) {
  for (const char* head : {"OFF 3 1 0\n", "OFF\n3 1\n", "OFF\n3\n1 0\n", "#\n\nOFF # a\n# b\n3 1 0\n"}) {
    const LoadedFile file(head + std::string("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    EXPECT_EQ(file.document->triangles().size(), 1U) << head;
    EXPECT_EQ(file.written(), file.bytes);
  }
}

TEST(Off, SaysWhatIsWrongAndWhere) {
  const std::string head = "OFF\n3 1 0\n0 0 0\n1 0 0\n";
  struct Row {
    std::string bytes;
    Cause cause;
    const char* message;
  };
  const Row rows[] = {
      {"", Cause::MalformedMesh,
       "begins with OFF, COFF, NOFF or the like instead of the end of the file (line 1)"},
      {"OFFS\n", Cause::MalformedMesh, "instead of \"OFFS\""},
      {"4OFF\n3 1 0\n", Cause::UnsupportedFormat,
       "the vertices of \"4OFF\" do not have three coordinates (line 1)"},
      {"nOFF\n3\n3 1 0\n", Cause::UnsupportedFormat, "\"nOFF\""},
      {"OFF BINARY\n", Cause::UnsupportedFormat, "a binary OFF"},
      {"OFF\nthree 1 0\n", Cause::MalformedMesh,
       "the count of vertices is no whole number but \"three\" (line 2)"},
      {"OFF\n3 -1 0\n", Cause::MalformedMesh, "the count of faces"},
      {"OFF\n0 0 0\n", Cause::EmptyMesh, "no vertex"},
      {"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", Cause::EmptyMesh, "no face"},
      {head + "0 y 0\n3 0 1 2\n", Cause::MalformedMesh,
       "vertex 2: coordinate y is not a number but \"y\" (line 5)"},
      {head + "0 nan 0\n3 0 1 2\n", Cause::NonFinitePosition,
       "vertex 2: coordinate y is \"nan\", not a finite number"},
      {head + "0 1 1e99\n3 0 1 2\n", Cause::NonFinitePosition, "beyond 1e60 (line 5)"},
      {head + "0 1 0\n3 0 1 3\n", Cause::IndexOutOfRange, "face 0 uses vertex 3 of 3 (line 6)"},
      {head + "0 1 0\n3 0 -1 2\n", Cause::IndexOutOfRange, "face 0 uses vertex -1 of 3"},
      {head + "0 1 0\n2 0 1  \n", Cause::MalformedMesh, "face 0 has 2 corners; it needs at least 3 (line 6)"},
      {head + "0 1 0\n-3 0 1 2\n", Cause::MalformedMesh, "face 0 has -3 corners"},
      {head + "0 1 0\n99 0 1 2\n", Cause::MalformedMesh, "the file ends in face 0"},
      {head + "0 1 0\n3 0 x 2\n", Cause::MalformedMesh, "a vertex index is not a number but \"x\""},
      {"NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 a\n0 1 0 0 0 1\n3 0 1 2\n", Cause::MalformedMesh,
       "vertex 1: its normal is not a number but \"a\" (line 4)"},
      {"OFF\n1000000 1000000000 0\n", Cause::TooLarge, "(max-triangles)"},
      {"OFF\n1000000000 1 0\n", Cause::TooLarge, "(max-vertices)"},
      {"OFF\n10000000 10000000 0\n0 0 0\n", Cause::MalformedMesh, "too short for 10000000 vertices"},
  };
  for (const Row& row : rows) {
    const Error error = error_of(row.bytes, Format::Off);
    EXPECT_EQ(error.cause, row.cause) << row.bytes << error.message;
    EXPECT_THAT(error.message, HasSubstr(row.message)) << row.bytes;
  }
}

TEST(Off, EveryPrefixIsAnErrorOrAMesh) {
  expect_prefixes_survive(kScan, Format::Off);
  expect_prefixes_survive(
      "STCNOFF\n3 1 0\n0 0 0 0 0 1 9 8 7\n1 0 0 0 0 1 9 8 7\n0 1 0 0 0 1 9 8 7\n3 0 1 2\n", Format::Off);
}

TEST(Off, LimitsAreKept) {
  EXPECT_THAT(error_of(kScan, Format::Off, {.max_vertices = 4}).message, HasSubstr("(max-vertices)"));
  EXPECT_THAT(error_of(kScan, Format::Off, {.max_triangles = 3}).message, HasSubstr("(max-triangles)"));
  EXPECT_THAT(error_of(kScan, Format::Off, {.max_line_bytes = 20}).message,
              HasSubstr("(max-line-bytes) (line 6)"));
  EXPECT_EQ(
      error_of(kScan, Format::Off, {.max_vertices = 5, .max_triangles = 4, .max_line_bytes = 40}).message,
      "accepted");
}

TEST(Off, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(error_of(kScan, Format::Off, {}, {.stop = stop.get_token()}).cause, Cause::Cancelled);
}

TEST(Off, NamesPlaces) {
  const LoadedFile file(kScan);
  EXPECT_EQ(file.document->vertex_place(2), "vertex 2 (line 8)");
  EXPECT_EQ(file.document->triangle_place(1), "face 0 (line 11)");
  EXPECT_EQ(file.document->triangle_place(3), "face 2 (line 13)");
}

}  // namespace
}  // namespace burnish::testing
