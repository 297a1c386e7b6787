#include "core/io/ply.h"

#include <gmock/gmock.h>

#include <sstream>

#include "tests/core/ply_fixture.h"

namespace burnish::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

/// The places where two files of one size differ.
std::vector<std::size_t> differences(const std::string& a, const std::string& b) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (a[i] != b[i]) places.push_back(i);
  }
  return places;
}

TEST(Ply, ReadsVerticesFacesAndPolygonsOfEveryEncoding) {
  for (const PlyEncoding encoding : kEncodings) {
    for (const PlyType position : {PlyType::Float32, PlyType::Float64}) {
      const LoadedFile file(rich_ply(encoding, position));
      EXPECT_EQ(file.document->format(), Format::Ply);
      EXPECT_THAT(file.document->positions(), ElementsAre(Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{1, 1, 0.25},
                                                          Vec3d{0, 1, 0}, Vec3d{0.5, 0.5, 1}));
      EXPECT_THAT(file.document->triangles(),
                  ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 1, 4}, Triangle{2, 3, 4}));
    }
  }
}

TEST(Ply, ComesBackByteForByteWhenNothingMoved) {
  for (const PlyEncoding encoding : kEncodings) {
    for (const char* behind : {"", "\n", "whatever stands behind\n"}) {
      const LoadedFile file(rich_ply(encoding) + behind);
      EXPECT_EQ(file.written(), file.bytes);
    }
  }
}

TEST(Ply, OfTextChangesOnlyTheNumbersOfMovedVerticesAndTheirNormals) {
  LoadedFile file(rich_ply(PlyEncoding::Text));
  file.move(1, {0, 0, 0.25});
  const auto was = lines(file.bytes), is = lines(file.written());
  ASSERT_EQ(was.size(), is.size());
  std::vector<std::string> changed;
  for (std::size_t i = 0; i < was.size(); ++i) {
    if (was[i] != is[i]) changed.push_back(is[i]);
  }
  // Vertex 1, and of its neighbours, all but vertex 3, the normals. Vertex 3 shares position with nobody and
  // no triangle with vertex 1.
  ASSERT_EQ(changed.size(), 4U);
  EXPECT_TRUE(changed[0].starts_with("0 0 0 -")) << changed[0];
  EXPECT_TRUE(changed[1].starts_with("1.00000000 0.00000000 0.25000000 ")) << changed[1];
  EXPECT_TRUE(changed[1].ends_with(" 10 255 51 255 0.1 0.25 0.75")) << changed[1];
  EXPECT_TRUE(changed[2].starts_with("1 1 0.25 ")) << changed[2];
  EXPECT_TRUE(changed[3].starts_with("0.5 0.5 1 ")) << changed[3];
}

TEST(Ply, OfBinaryChangesOnlyTheBytesOfMovedVerticesAndTheirNormals) {
  for (const PlyEncoding encoding : {PlyEncoding::LittleEndian, PlyEncoding::BigEndian}) {
    for (const PlyType position : {PlyType::Float32, PlyType::Float64}) {
      LoadedFile file(rich_ply(encoding, position));
      file.move(3, {0, 0, -0.5});
      const std::string written = file.written();
      ASSERT_EQ(written.size(), file.bytes.size());
      const std::size_t size = size_of(position), row = 3 * size + 3 * 4 + 4 + 3 * 4;
      const std::size_t begin = file.bytes.find("end_header\n") + 11 + 4 + 1 + 4;
      for (const std::size_t place : differences(file.bytes, written)) {
        ASSERT_GE(place, begin);
        const std::size_t vertex = (place - begin) / row, column = (place - begin) % row;
        EXPECT_LT(column, 3 * size + 12) << "a property that nobody changes";
        EXPECT_TRUE(column >= 3 * size || vertex == 3);
        EXPECT_NE(vertex, 1U) << "no triangle joins vertices 1 and 3";
      }
      const LoadedFile again(written);
      EXPECT_EQ(again.document->positions()[3], (Vec3d{0, 1, -0.5}));
    }
  }
}

TEST(Ply, RecomputesNormalsAsAngleWeightedSumsInEveryEncoding) {
  for (const PlyEncoding encoding : kEncodings) {
    PlyBody body(encoding);
    for (const auto& v : {std::array{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}})
      body.put(PlyType::Float32, {v[0], v[1], v[2], 0, 0, 1}).end();
    body.put(PlyType::Uint8, 3).put(PlyType::Int32, {0, 1, 2}).end();
    LoadedFile file("ply\n" + format_line(encoding) +
                    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                    "property float nx\nproperty float ny\nproperty float nz\n"
                    "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                    body.bytes());
    file.move(1, {0, 0, 1});  // the triangle now leans by 45 degrees
    const LoadedFile again(file.written());
    const auto shared = again.document->shared_attributes(again.moved(), {});
    ASSERT_TRUE(shared && shared->normals);
    for (std::size_t v = 0; v < 3; ++v) {
      const float* const n = &shared->normals->values[3 * shared->normals->corners[0][v]];
      EXPECT_NEAR(n[0], -std::sqrt(0.5), 1e-6);
      EXPECT_NEAR(n[1], 0, 1e-6);
      EXPECT_NEAR(n[2], std::sqrt(0.5), 1e-6);
    }
  }
}

TEST(Ply, KeepsTheDigitsOfCoordinatesFarFromTheOrigin) {
  for (const PlyEncoding encoding : kEncodings) {
    PlyBody body(encoding);
    for (const auto& v : {std::array{5e6, 0.0, 0.0}, {5e6 + 1, 0.0, 0.0}, {5e6, 1.0, 0.0}})
      body.put(PlyType::Float64, {v[0], v[1], v[2]}).end();
    body.put(PlyType::Uint8, 3).put(PlyType::Int32, {0, 1, 2}).end();
    LoadedFile file("ply\n" + format_line(encoding) +
                    "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
                    "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                    body.bytes());
    file.move(1, {0.0001220703125, 0, 0});
    const LoadedFile again(file.written());
    EXPECT_NEAR(again.document->positions()[1].x, 5e6 + 1.0001220703125, 1e-7);
    EXPECT_EQ(again.document->positions()[0], (Vec3d{5e6, 0, 0}));
    // As another format too: floats would be half a unit off.
    const LoadedFile obj(file.written(Format::Obj));
    EXPECT_NEAR(LoadedFile(obj.written(Format::Ply)).document->positions()[1].x, 5e6 + 1.0001220703125, 1e-7);
  }
}

TEST(Ply, KeepsASmoothSeamSmooth) {
  // Two copies of an edge with one normal, as at a seam of textures.
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "element face 2\nproperty list uchar uint vertex_index\nend_header\n"
      "0 0 0 0 0 1\n0 1 0 0 0 1\n-1 0 0 0 0 1\n0 0 0 0 0 1\n0 1 0 0 0 1\n1 0 0 0 0 1\n3 0 1 2\n3 3 5 4\n";
  LoadedFile file(text);
  file.move(5, {0, 0, 1});
  const auto is = lines(file.written());
  EXPECT_EQ(is[12], is[15]);
  EXPECT_NE(is[12], "0 0 0 0 0 1");
}

TEST(Ply, ReadsStripsAndKeepsThem) {
  for (const PlyEncoding encoding : kEncodings) {
    PlyBody body(encoding);
    for (int v = 0; v < 6; ++v) body.put(PlyType::Float32, {v / 2 * 1.0, v % 2 * 1.0, 0}).end();
    body.put(PlyType::Int32, {11, 0, 1, 2, 3, 3, -1, 2, 3, 4, 5, -1}).end();
    LoadedFile file("ply\n" + format_line(encoding) +
                    "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
                    "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                    body.bytes());
    EXPECT_THAT(file.document->triangles(),
                ElementsAre(Triangle{0, 1, 2}, Triangle{2, 1, 3}, Triangle{2, 3, 4}, Triangle{4, 3, 5}));
    EXPECT_EQ(file.written(), file.bytes);
    EXPECT_EQ(file.document->triangle_place(3), "triangle 3 of the strips");
  }
}

TEST(Ply, TakesEveryTypeOfCountAndIndex) {
  for (const PlyEncoding encoding : kEncodings) {
    for (const PlyType count :
         {PlyType::Int8, PlyType::Uint8, PlyType::Int16, PlyType::Uint16, PlyType::Int32, PlyType::Uint32}) {
      for (const PlyType index : {PlyType::Int8, PlyType::Uint8, PlyType::Int16, PlyType::Uint16,
                                  PlyType::Int32, PlyType::Uint32}) {
        PlyBody body(encoding);
        for (int v = 0; v < 3; ++v) body.put(PlyType::Float32, {v * 1.0, v % 2 * 1.0, 0}).end();
        body.put(count, 3).put(index, {2, 1, 0}).end();
        const LoadedFile file("ply\n" + format_line(encoding) +
                              "element vertex 3\nproperty float x\nproperty float32 y\nproperty float z\n"
                              "element face 1\nproperty list " +
                              std::string(name_of(count)) + ' ' + std::string(name_of(index)) +
                              " vertex_index\nend_header\n" + body.bytes());
        EXPECT_THAT(file.document->triangles(), ElementsAre(Triangle{2, 1, 0}));
      }
    }
  }
}

TEST(Ply, HeadersMayEndTheirLinesInAnyWay) {
  const std::string lf = rich_ply(PlyEncoding::LittleEndian);
  const std::size_t end = lf.find("end_header\n") + 11;
  for (const char* line_end : {"\r\n", "\r"}) {
    std::string bytes;
    for (const char c : lf.substr(0, end)) c == '\n' ? bytes += line_end : bytes += c;
    const LoadedFile file(bytes + lf.substr(end));
    EXPECT_EQ(file.document->positions()[2], (Vec3d{1, 1, 0.25}));
    EXPECT_EQ(file.written(), file.bytes);
  }
}

TEST(Ply, SaysWhichNormalsItCannotRecompute) {
  const auto file = [](const std::string& vertex_normals, const std::string& face_normals) {
    const std::string of_vertex = vertex_normals.empty() ? "" : " 0 0 1",
                      of_face = face_normals.empty() ? "" : " 0 0 1";
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
        vertex_normals + "element face 1\nproperty list uchar int vertex_indices\n" + face_normals +
        "end_header\n";
    for (const char* position : {"0 0 0", "1 0 0", "0 1 0"}) text += position + of_vertex + '\n';
    return LoadedFile(text + "3 0 1 2" + of_face + '\n');
  };
  const auto normals = [](const std::string& type) {
    return "property " + type + " nx\nproperty " + type + " ny\nproperty " + type + " nz\n";
  };
  const auto said = [](const LoadedFile& loaded) {
    std::vector<std::string> messages;
    for (const Warning& warning : loaded.encoded().warnings)
      messages.push_back(warning.code + ' ' + warning.message);
    return messages;
  };
  EXPECT_THAT(said(file("", "")), ElementsAre());
  EXPECT_THAT(said(file(normals("float"), "")), ElementsAre());
  EXPECT_THAT(said(file(normals("char"), "")), ElementsAre(HasSubstr("normals_not_recomputed the vertices")));
  EXPECT_THAT(said(file(normals("float"), normals("float"))),
              ElementsAre(HasSubstr("normals_not_recomputed the faces")));
}

TEST(Ply, PinsByAPropertyOfTheVertices) {
  const LoadedFile file(rich_ply(PlyEncoding::BigEndian));
  const auto pinned = file.document->attribute_vertices("quality", {});
  ASSERT_TRUE(pinned);
  EXPECT_THAT(*pinned, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(file.document->attribute_vertices("curvature", {}).error().message,
              HasSubstr("the mesh has no attribute \"curvature\"; it has \"x\", \"y\""));
}

}  // namespace
}  // namespace burnish::testing
