#include "core/io/estimate.h"
#include "tests/core/ply_fixture.h"

namespace burnish::testing {
namespace {

/// What the arrays that every job holds at once take: less than any honest peak.
std::uint64_t least_memory(const Shape& shape) {
  return shape.positions.size() * (sizeof(Vec3d) + 4 * sizeof(Vec3f)) +
         shape.triangles.size() * 5 * sizeof(Triangle);
}

void expect_about(const Shape& shape, const std::string& bytes, const char* what) {
  const Estimate said = estimate(std::string_view(bytes), std::nullopt);
  const auto triangles = static_cast<double>(shape.triangles.size()),
             vertices = static_cast<double>(shape.positions.size());
  EXPECT_NEAR(static_cast<double>(said.triangles), triangles, 0.1 * triangles + 3) << what;
  EXPECT_NEAR(static_cast<double>(said.vertices), vertices, 0.1 * vertices + 20) << what;
  EXPECT_GE(said.memory_bytes, least_memory(shape)) << what;
  EXPECT_LE(said.memory_bytes, 8 * least_memory(shape) + 8 * bytes.size()) << what;
}

std::string text_stl(const Shape& shape) {
  std::string text = "solid s\n";
  for (const Triangle& t : shape.triangles) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const Index v : t) {
      const Vec3d& p = shape.positions[v];
      text += "vertex " + std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + '\n';
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid s\n";
}

std::string ply(const Shape& shape, PlyEncoding encoding) {
  PlyBody body(encoding);
  for (const Vec3d& p : shape.positions) body.put(PlyType::Float32, {p.x, p.y, p.z}).end();
  for (const Triangle& t : shape.triangles)
    body.put(PlyType::Uint8, 3).put(PlyType::Int32, {1.0 * t[0], 1.0 * t[1], 1.0 * t[2]}).end();
  return "ply\n" + format_line(encoding) + "element vertex " + std::to_string(shape.positions.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(shape.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n" +
         body.bytes();
}

TEST(FormatsEstimate, TellsVerticesTrianglesAndMemoryOfWellFormedFiles) {
  for (const Shape& shape : {sphere(1), sphere(4), with_noise(cube(30), 0.01)}) {
    const LoadedFile file(to_obj(shape));
    expect_about(shape, file.written(Format::Stl), "binary STL");
    expect_about(shape, text_stl(shape), "text STL");
    expect_about(shape, file.written(Format::Off), "OFF");
    for (const PlyEncoding encoding : kEncodings) expect_about(shape, ply(shape, encoding), "PLY");
  }
}

TEST(FormatsEstimate, CountsTheTrianglesOfQuads) {
  std::string off = "OFF\n400 361 0\n", faces;
  PlyBody vertices(PlyEncoding::LittleEndian), quads(PlyEncoding::LittleEndian);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      off += std::to_string(x) + ' ' + std::to_string(y) + " 0\n";
      vertices.put(PlyType::Float32, {1.0 * x, 1.0 * y, 0});
      if (x == 19 || y == 19) continue;
      const int v = 20 * y + x;
      faces += "4 " + std::to_string(v) + ' ' + std::to_string(v + 1) + ' ' + std::to_string(v + 21) + ' ' +
               std::to_string(v + 20) + '\n';
      quads.put(PlyType::Uint8, 4).put(PlyType::Int32, {1.0 * v, v + 1.0, v + 21.0, v + 20.0});
    }
  }
  off += faces;
  const std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 400\nproperty float x\nproperty float "
      "y\nproperty float z\n"
      "element face 361\nproperty list uchar int vertex_indices\nend_header\n" +
      vertices.bytes() + quads.bytes();
  for (const std::string& bytes : {off, binary}) {
    ASSERT_EQ(LoadedFile(bytes).document->triangles().size(), 722U);
    EXPECT_NEAR(static_cast<double>(estimate(std::string_view(bytes), std::nullopt).triangles), 722, 8);
  }
}

TEST(FormatsEstimate, BelievesNoCountThatTheBytesCannotHold) {
  for (const char* bytes :
       {"OFF\n1000000000 1000000000 0\n0 0 0\n",
        "ply\nformat ascii 1.0\nelement vertex 1000000000\nelement face 1000000000\nend_header\n"}) {
    const Estimate said = estimate(std::string_view(bytes), std::nullopt);
    EXPECT_LT(said.memory_bytes, 1U << 20);
    EXPECT_GT(said.memory_bytes, 0U);
  }
}

}  // namespace
}  // namespace burnish::testing
