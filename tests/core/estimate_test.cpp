#include "core/io/estimate.h"

#include <gtest/gtest.h>

#include "tests/core/draco_fixture.h"
#include "tests/support/glb.h"
#include "tests/support/shapes.h"

namespace burnish::testing {
namespace {

/// What the arrays that every job holds at once take, to the byte: less than any honest peak.
std::uint64_t least_memory(std::size_t vertices, std::size_t triangles) {
  return vertices * (sizeof(Vec3d) + 4 * sizeof(Vec3f)) + triangles * 5 * sizeof(Triangle);
}

std::string written(const Shape& shape, DracoMethod method, int bits) {
  Moved moved(shape.positions, shape.triangles);
  const DracoOptions options{.method = method, .position_bits = bits};
  const auto encoded = encode_as_draco(moved.view(), shape.triangles, {}, options, kRun);
  EXPECT_TRUE(encoded.ok());
  return encoded.ok() ? encoded->bytes : std::string();
}

std::string with_normals_and_textures(const Shape& shape) {
  std::string text;
  for (const Vec3d& p : shape.positions) {
    text += "v " + std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + '\n';
  }
  for (std::size_t v = 0; v < shape.positions.size(); ++v) text += "vt 0.250000 0.750000\n";
  for (std::size_t v = 0; v < shape.positions.size(); ++v) text += "vn 0.000000 0.600000 0.800000\n";
  for (const Triangle& t : shape.triangles) {
    text += 'f';
    for (const Index v : t) {
      const std::string number = std::to_string(v + 1);
      text += ' ' + number + '/' + number + '/' + number;
    }
    text += '\n';
  }
  return text;
}

void expect_about(const Shape& shape, const std::string& bytes, const char* what) {
  const Estimate said = estimate(std::string_view(bytes), std::nullopt);
  const auto triangles = static_cast<double>(shape.triangles.size());
  EXPECT_NEAR(static_cast<double>(said.triangles), triangles, 0.1 * triangles + 1) << what;
  const std::uint64_t least = least_memory(shape.positions.size(), shape.triangles.size());
  EXPECT_GE(said.memory_bytes, least) << what;
  EXPECT_LE(said.memory_bytes, 8 * least + 8 * bytes.size()) << what;
}

TEST(Estimate, TellsTrianglesAndMemoryOfWellFormedFiles) {
  for (const Shape& shape : {sphere(1), sphere(4), grid(90), with_noise(cube(30), 0.01)}) {
    expect_about(shape, to_obj(shape), "plain OBJ");
    expect_about(shape, with_normals_and_textures(shape), "OBJ with everything");
    for (const DracoMethod method : kMethods) {
      for (const int bits : {0, 11}) expect_about(shape, written(shape, method, bits), "Draco");
    }
  }
}

TEST(Estimate, GrowsWithTheMesh) {
  std::uint64_t before_obj = 0, before_draco = 0, before_size = 0;
  for (const int n : {10, 20, 40, 80, 160}) {
    const std::string obj = to_obj(grid(n)), draco = written(grid(n), DracoMethod::Edgebreaker, 11);
    const std::uint64_t now_obj = estimate(std::string_view(obj), std::nullopt).memory_bytes;
    const std::uint64_t now_draco = estimate(std::string_view(draco), std::nullopt).memory_bytes;
    const std::uint64_t now_size = estimate(obj.size(), std::nullopt).memory_bytes;
    EXPECT_GT(now_obj, before_obj);
    EXPECT_GT(now_draco, before_draco);
    EXPECT_GT(now_size, before_size);
    before_obj = now_obj, before_draco = now_draco, before_size = now_size;
  }
}

TEST(Estimate, CountsWhatSmoothingTakesBeyondWhatIsFreeByThen) {
  const Shape shape = sphere(4);
  const std::string obj = to_obj(shape);
  const Estimate said = estimate(std::string_view(obj), std::nullopt);
  EXPECT_NEAR(static_cast<double>(said.vertices), static_cast<double>(shape.positions.size()),
              0.1 * static_cast<double>(shape.positions.size()));
  EXPECT_EQ(said.memory_with(0), said.memory_bytes);
  const std::uint64_t more = 1000 * said.triangles;
  EXPECT_GT(said.memory_with(more), said.memory_bytes + more / 2);
  EXPECT_LE(said.memory_with(more), said.memory_bytes + more);
  EXPECT_EQ(said.memory_with(2 * more), said.memory_with(more) + more);
}

TEST(Estimate, OfTheSizeAloneRefusesNothingThatTheBytesWouldLetPass) {
  const Shape shape = sphere(5);
  for (const std::string& bytes :
       {to_obj(shape), with_normals_and_textures(shape), written(shape, DracoMethod::Sequential, 0)}) {
    const auto format = detect_format(bytes);
    EXPECT_LE(estimate(bytes.size(), format).memory_bytes,
              estimate(std::string_view(bytes), format).memory_bytes);
  }
}

TEST(Estimate, CountsDeclaredTrianglesWithoutDecodingThem) {
  // A header and two counts; there is nothing behind them.
  const std::string head = std::string("DRACO\2\2\1", 8), billion = {'\x80', '\x94', '\xEB', '\xDC', '\x03'};
  const std::string sequential = head + std::string("\0\0\0", 3) + billion + billion;
  const std::string edgebreaker = head + std::string("\1\0\0\0", 4) + billion + billion;
  for (const std::string& bytes : {sequential, edgebreaker}) {
    const Estimate said = estimate(std::string_view(bytes), Format::Draco);
    EXPECT_EQ(said.triangles, 1'000'000'000U);
    EXPECT_GT(said.memory_bytes, std::uint64_t{100} << 30);
    EXPECT_LT(said.memory_bytes, std::uint64_t{1} << 40);
  }
}

TEST(Estimate, CountsWhatTheJsonOfAGlbDeclares) {
  for (const Shape& shape : {sphere(2), grid(90), sphere(5)}) {
    TestGlb glb;
    glb.mesh(shape);
    const std::string bytes = glb.bytes();
    expect_about(shape, bytes, "GLB");
    EXPECT_LE(estimate(bytes.size(), Format::Glb).memory_bytes,
              estimate(std::string_view(bytes), std::nullopt).memory_bytes);
    // A picture takes its own bytes and no more.
    glb.view(std::string(1 << 20, 'p'));
    const std::uint64_t more = estimate(std::string_view(glb.bytes()), std::nullopt).memory_bytes -
                               estimate(std::string_view(bytes), std::nullopt).memory_bytes;
    EXPECT_GE(more, std::uint64_t{2} << 20);
    EXPECT_LE(more, std::uint64_t{3} << 20);
    for (std::size_t size = 12; size < 1200; ++size) {
      EXPECT_GT(estimate(std::string_view(bytes).substr(0, size), std::nullopt).memory_bytes, 0U);
    }
  }
}

TEST(Estimate, BelievesWhatAGlbDeclaresForAdmission) {
  TestGlb glb;
  glb.mesh(sphere(0));
  glb.json["accessors"][2]["count"] = 3'000'000'000;
  EXPECT_EQ(estimate(std::string_view(glb.bytes()), std::nullopt).triangles, 1'000'000'000U);
}

TEST(Estimate, LooksPastMetadata) {
  const auto sphere = seamed_sphere();
  for (const DracoMethod method : kMethods) {
    const std::string bytes = write_with_library(*sphere, {.method = method, .position_bits = 11});
    EXPECT_EQ(estimate(std::string_view(bytes), std::nullopt).triangles, sphere->num_faces());
  }
}

TEST(Estimate, MeetsEveryTruncationWithANumber) {
  for (const DracoMethod method : kMethods) {
    const std::string whole = write_with_library(*seamed_sphere(), {.method = method, .position_bits = 11});
    for (std::size_t size = 0; size < std::min<std::size_t>(whole.size(), 400); ++size) {
      // A copy of its own size, so that the sanitizers see a read beyond the end.
      const std::vector<char> prefix(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const std::string_view bytes(prefix.data(), prefix.size());
      const std::uint64_t memory = estimate(bytes, Format::Draco).memory_bytes;
      EXPECT_LE(memory, estimate(std::string_view(whole), Format::Draco).memory_bytes) << size;
      EXPECT_EQ(memory == 0, size == 0) << size;
    }
  }
}

TEST(Estimate, FallsBackToTheSizeForWhatIsNoMesh) {
  const std::string binary(100'000, '\x01'), line(200'000, 'f'), cloud = std::string("DRACO\2\2\0\0\0\0", 11);
  EXPECT_EQ(estimate(std::string_view(binary), std::nullopt).memory_bytes,
            estimate(binary.size(), std::nullopt).memory_bytes);
  EXPECT_EQ(estimate(std::string_view(line), std::nullopt).memory_bytes,
            estimate(line.size(), Format::Obj).memory_bytes);
  EXPECT_EQ(estimate(std::string_view(cloud), std::nullopt).memory_bytes,
            estimate(cloud.size(), Format::Draco).memory_bytes);
  EXPECT_EQ(estimate(std::string_view(), std::nullopt).memory_bytes, 0U);
  EXPECT_GT(estimate(~std::uint64_t{0}, Format::Draco).memory_bytes, std::uint64_t{1} << 62);
}

}  // namespace
}  // namespace burnish::testing
