#include <gmock/gmock.h>

#include "core/io/estimate.h"
#include "tests/core/ply_fixture.h"

namespace burnish::testing {
namespace {

using ::testing::HasSubstr;

const std::string kVertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "element face 1\nproperty list char int vertex_indices\n";
const std::string kHeader = "ply\nformat ascii 1.0\n" + kVertices + kFaces + "end_header\n";
const std::string kThree = "0 0 0\n1 0 0\n0 1 0\n";

TEST(PlyHostile, EveryPrefixIsAnErrorOrAMesh) {
  for (const PlyEncoding encoding : kEncodings) expect_prefixes_survive(rich_ply(encoding), Format::Ply);
}

TEST(PlyHostile, EveryPrefixWithoutTheLastRowsIsAnError) {
  for (const PlyEncoding encoding : kEncodings) {
    const std::string bytes = rich_ply(encoding);
    for (std::size_t size = 0; size + 12 < bytes.size(); ++size)
      ASSERT_NE(error_of(bytes.substr(0, size), Format::Ply).message, "accepted") << size;
  }
}

TEST(PlyHostile, SaysWhatIsWrongAndWhere) {
  struct Row {
    std::string bytes;
    Cause cause;
    const char* message;
  };
  const Row rows[] = {
      {"", Cause::MalformedMesh, "the file ends before \"end_header\" (line 1)"},
      {"ply\nformat ascii 2.0\nend_header\n", Cause::UnsupportedFormat,
       "version \"2.0\" of PLY; 1.0 is known (line 2)"},
      {"ply\nformat utf8 1.0\nend_header\n", Cause::MalformedMesh, "(line 2)"},
      {"ply\nformat ascii 1.0\nelement vertex many\n", Cause::MalformedMesh,
       "element \"vertex\" has \"many\" rows, which is not a count (line 3)"},
      {"ply\nformat ascii 1.0\nelement vertex -1\n", Cause::MalformedMesh, "\"-1\" rows"},
      {"ply\nformat ascii 1.0\nproperty float x\n", Cause::MalformedMesh, "before any element (line 3)"},
      {"ply\nformat ascii 1.0\nelement a 1\nelement a 1\n", Cause::MalformedMesh, "declared twice (line 4)"},
      {"ply\nformat ascii 1.0\nelement a 1\nproperty long x\n", Cause::MalformedMesh, "the type \"long\""},
      {"ply\nformat ascii 1.0\nelement a 1\nproperty list float int x\n", Cause::MalformedMesh,
       "counted with \"float\""},
      {"ply\nformat ascii 1.0\nelements a 1\n", Cause::MalformedMesh, "holds \"elements\""},
      {"ply\nformat ascii 1.0\n" + kFaces + "end_header\n", Cause::EmptyMesh, "no vertex"},
      {"ply\nformat ascii 1.0\n" + kVertices + "end_header\n" + kThree, Cause::NotATriangleMesh,
       "points only"},
      {"ply\nformat ascii 1.0\n" + kVertices +
           "element face 0\nproperty list uchar int vertex_indices\nend_header\n" + kThree,
       Cause::EmptyMesh, "no face"},
      {"ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty float y\nproperty float z\n" +
           kFaces + "end_header\n",
       Cause::UnsupportedFormat, "\"x\" is int; positions must be float or double (line 3)"},
      {"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float z\n" + kFaces +
           "end_header\n",
       Cause::MalformedMesh, "no property \"y\" (line 3)"},
      {"ply\nformat ascii 1.0\n" + kVertices +
           "element face 1\nproperty list uchar float vertex_indices\nend_header\n",
       Cause::UnsupportedFormat, "indices must be whole numbers (line 7)"},
      {"ply\nformat ascii 1.0\n" + kVertices + "element face 1\nproperty int a\nend_header\n",
       Cause::MalformedMesh, "no list \"vertex_indices\" (line 7)"},
      {kHeader + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n", Cause::MalformedMesh,
       "vertex 1: \"x\" is not a number here (line 11)"},
      {kHeader + "0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n", Cause::NonFinitePosition,
       "vertex 2: coordinate z is not a finite number (line 12)"},
      {kHeader + "0 0 0\n1 0 0\n0 1 1e61\n3 0 1 2\n", Cause::NonFinitePosition,
       "coordinate z is beyond 1e60"},
      {kHeader + kThree + "3 0 1 3\n", Cause::IndexOutOfRange, "face 0 uses vertex 3 of 3 (line 13)"},
      {kHeader + kThree + "3 0 -1 2\n", Cause::IndexOutOfRange, "face 0 uses vertex -1 of 3 (line 13)"},
      {kHeader + kThree + "-3 0 1 2\n", Cause::MalformedMesh, "face 0 has a list of -3 items"},
      {kHeader + kThree + "2 0 1\n", Cause::MalformedMesh, "face 0 has 2 corners; it needs at least 3"},
      {kHeader + kThree + "3 0 1", Cause::MalformedMesh, "the file ends in face 0"},
      {kHeader + kThree + "99999999999999999999 0 1 2", Cause::MalformedMesh, "is not a number here"},
  };
  for (const Row& row : rows) {
    const Error error = error_of(row.bytes, Format::Ply);
    EXPECT_EQ(error.cause, row.cause) << row.bytes << error.message;
    EXPECT_THAT(error.message, HasSubstr(row.message)) << row.bytes;
  }
}

TEST(PlyHostile, OfBinaryNamesTheByte) {
  const std::string header = "ply\nformat binary_little_endian 1.0\n" + kVertices + kFaces + "end_header\n";
  const auto bytes_of = [&](double x, double count, std::initializer_list<double> corners) {
    PlyBody body(PlyEncoding::LittleEndian);
    body.put(PlyType::Float32, {x, 0, 0, 1, 0, 0, 0, 1, 0})
        .put(PlyType::Int8, count)
        .put(PlyType::Int32, corners);
    return header + body.bytes();
  };
  const std::string first = std::to_string(header.size()), face = std::to_string(header.size() + 36),
                    index = std::to_string(header.size() + 36 + 1 + 8);
  EXPECT_THAT(error_of(bytes_of(NAN, 3, {0, 1, 2}), Format::Ply).message,
              HasSubstr("vertex 0: coordinate x is not a finite number (byte " + first + ")"));
  EXPECT_THAT(error_of(bytes_of(0, 3, {0, 1, 7}), Format::Ply).message,
              HasSubstr("face 0 uses vertex 7 of 3 (byte " + index + ")"));
  EXPECT_THAT(error_of(bytes_of(0, 3, {0, 1, -2}), Format::Ply).message,
              HasSubstr("face 0 uses vertex -2 of 3"));
  EXPECT_THAT(error_of(bytes_of(0, -3, {0, 1, 2}), Format::Ply).message,
              HasSubstr("face 0 has a list of -3 items"));
  EXPECT_THAT(error_of(bytes_of(0, 127, {0, 1, 2}), Format::Ply).message,
              HasSubstr("the file ends in face 0"));
  EXPECT_THAT(error_of(bytes_of(0, 2, {0, 1, 2}), Format::Ply).message, HasSubstr("(byte " + face + ")"));
}

TEST(PlyHostile, BelievesNoCountThatTheFileCannotHold) {
  for (const PlyEncoding encoding : kEncodings) {
    for (const std::string count : {"1000000000", "4294967295", "18446744073709551615"}) {
      const Limits limits{.max_vertices = ~std::uint64_t{0}, .max_triangles = ~std::uint64_t{0}};
      const std::string vertices =
          "element vertex " + count + "\nproperty float x\nproperty float y\nproperty float z\n";
      const std::string faces = "element face " + count + "\nproperty list uchar int vertex_indices\n";
      PlyBody three(encoding);
      three.put(PlyType::Float32, {0, 0, 0, 1, 0, 0, 0, 1, 0}).end();
      for (const std::string& header :
           {vertices + kFaces, kVertices + faces,
            "element spare " + count + "\nproperty uchar a\n" + kVertices + kFaces,
            "element spare " + count + "\nproperty list uchar uchar a\n" + kVertices + kFaces}) {
        const Error error = error_of(
            "ply\n" + format_line(encoding) + header + "end_header\n" + three.bytes(), Format::Ply, limits);
        EXPECT_EQ(error.cause, Cause::MalformedMesh) << header << error.message;
      }
    }
  }
}

TEST(PlyHostile, AnElementWithoutPropertiesHasNothingToRead) {
  const LoadedFile file("ply\nformat ascii 1.0\nelement spare 18446744073709551615\n" + kVertices + kFaces +
                        "end_header\n" + kThree + "3 0 1 2\n");
  EXPECT_EQ(file.written(), file.bytes);
}

TEST(PlyHostile, LimitsAreKept) {
  const std::string bytes = rich_ply(PlyEncoding::Text);
  struct Row {
    Limits limits;
    const char* name;
  };
  for (const Row& row :
       {Row{{.max_vertices = 4}, "(max-vertices)"}, Row{{.max_triangles = 3}, "(max-triangles)"},
        Row{{.max_triangles = 2}, "(max-triangles)"}, Row{{.max_attributes = 20}, "(max-attributes)"},
        Row{{.max_attributes = 4}, "(max-attributes)"}, Row{{.max_line_bytes = 20}, "(max-line-bytes)"},
        Row{{.max_bytes = 100}, "(max-bytes)"}}) {
    const Error error = error_of(bytes, Format::Ply, row.limits);
    EXPECT_EQ(error.cause, Cause::TooLarge) << row.name;
    EXPECT_THAT(error.message, HasSubstr(row.name));
  }
  EXPECT_EQ(
      error_of(bytes, Format::Ply, {.max_vertices = 5, .max_triangles = 4, .max_attributes = 21}).message,
      "accepted");
  const std::string long_line = kHeader + kThree + "3 0 1 2" + std::string(200, ' ') + "\n";
  EXPECT_THAT(error_of(long_line, Format::Ply, {.max_line_bytes = 100}).message,
              HasSubstr("(max-line-bytes) (line 13)"));
}

TEST(PlyHostile, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  for (const PlyEncoding encoding : kEncodings)
    EXPECT_EQ(error_of(rich_ply(encoding), Format::Ply, {}, {.stop = stop.get_token()}).cause,
              Cause::Cancelled);
}

}  // namespace
}  // namespace burnish::testing
