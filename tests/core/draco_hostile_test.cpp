// Draco files that nobody's encoder wrote.
#include <array>
#include <ctime>
#include <random>

#include "tests/core/draco_fixture.h"

namespace burnish::testing {
namespace {

Cause cause_of(std::string_view bytes, const Limits& limits = {}) {
  const auto document = decode_draco(bytes, limits, kRun);
  EXPECT_FALSE(document.ok());
  return document.ok() ? Cause::Internal : document.error().cause;
}

std::unique_ptr<draco::Mesh> tetrahedron() {
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(4);
  add_point_attribute<float>(*mesh, DracoAttribute::POSITION, draco::DT_FLOAT32, 3, false,
                             {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  constexpr std::array<std::array<std::uint32_t, 3>, 4> kFaces = {
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  for (const auto& f : kFaces) {
    mesh->AddFace({draco::PointIndex(f[0]), draco::PointIndex(f[1]), draco::PointIndex(f[2])});
  }
  return mesh;
}

// The layout of a small sequential file: header (11 bytes), triangles, points, method, then indices as bytes.
constexpr std::size_t kTriangleCount = 11, kPointCount = 12, kFirstIndex = 14;

TEST(DracoHostile, IndexOutOfRangeNamesTriangleAndPoint) {
  std::string bytes = write_with_library(*tetrahedron(), {});
  ASSERT_EQ(bytes[kTriangleCount], 4);
  ASSERT_EQ(bytes[kPointCount], 4);
  bytes[kFirstIndex + 3 * 2 + 1] = 9;
  const auto document = decode_draco(bytes, Limits{}, kRun);
  ASSERT_FALSE(document.ok());
  EXPECT_EQ(document.error().cause, Cause::IndexOutOfRange);
  EXPECT_EQ(document.error().message, "triangle 2 uses point 9 of 4");
}

TEST(DracoHostile, NonFinitePositionNamesThePoint) {
  std::string bytes = write_with_library(*tetrahedron(), {});
  const float nan = std::nanf("");
  std::memcpy(bytes.data() + bytes.size() - 2 * sizeof(float), &nan, sizeof nan);
  const auto document = decode_draco(bytes, Limits{}, kRun);
  ASSERT_FALSE(document.ok());
  EXPECT_EQ(document.error().cause, Cause::NonFinitePosition);
  EXPECT_NE(document.error().message.find("point 3"), std::string::npos) << document.error().message;
}

TEST(DracoHostile, EveryTruncatedPrefixIsAnError) {
  for (const auto method : {DracoMethod::Sequential, DracoMethod::Edgebreaker}) {
    for (const int bits : {0, 11}) {
      const std::string bytes = write_with_library(*tetrahedron(), {.method = method, .position_bits = bits});
      ASSERT_NE(decoded(bytes), nullptr);
      for (std::size_t size = 0; size < bytes.size(); ++size) {
        // A copy of its own size, so that the sanitizers see a read beyond the end.
        const std::vector<char> prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_EQ(cause_of({prefix.data(), prefix.size()}), Cause::MalformedMesh)
            << size << " of " << bytes.size() << " bytes, " << bits << " bits";
      }
    }
  }
}

/// Decoding and, when that succeeds, encoding must come back, with whatever verdict.
void survive(const std::string& bytes) {
  const auto document = decode_draco(bytes, Limits{}, kRun);
  if (!document.ok()) return;
  Moved moved(**document);
  for (Vec3f& p : moved.after) p *= 1.01f;
  for (const auto method : {DracoMethod::Sequential, DracoMethod::Edgebreaker}) {
    OutputOptions options;
    options.draco.method = method;
    const auto encoded = (*document)->encode_same(moved.view(), options, kRun);
    if (encoded.ok()) {
      EXPECT_TRUE(decode_draco(encoded->bytes, Limits{}, kRun).ok());
    }
  }
  EXPECT_TRUE((*document)->shared_attributes(moved.view(), kRun).ok());
}

TEST(DracoHostile, FlippedBytesNeverCrash) {
  std::mt19937 random(20240611);
  for (const auto method : {DracoMethod::Sequential, DracoMethod::Edgebreaker}) {
    for (const int bits : {0, 10}) {
      const std::string bytes = write_with_library(
          *seamed_sphere(),
          {.method = method, .position_bits = bits, .normal_bits = bits, .texture_bits = bits});
      for (int round = 0; round < 150; ++round) {
        std::string mutant = bytes;
        for (int flips = 0; flips < 1 + round % 3; ++flips) {
          mutant[11 + random() % (mutant.size() - 11)] = static_cast<char>(random());
        }
        SCOPED_TRACE(round);
        survive(mutant);
      }
    }
  }
}

TEST(DracoHostile, FlippedBytesOfTheFirstHundredNeverCrash) {
  for (const auto method : {DracoMethod::Sequential, DracoMethod::Edgebreaker}) {
    const std::string bytes = write_with_library(*tetrahedron(), {.method = method, .position_bits = 8});
    for (std::size_t at = 5; at < std::min<std::size_t>(bytes.size(), 100); ++at) {
      for (const int value : {0, 1, 0x7F, 0x80, 0xFF}) {
        std::string mutant = bytes;
        mutant[at] = static_cast<char>(value);
        SCOPED_TRACE(std::to_string(at) + " = " + std::to_string(value));
        survive(mutant);
      }
    }
  }
}

TEST(DracoHostile, DeclaredCountsAreRefusedBeforeMemoryIsTaken) {
  // Two billion triangles in a file of a hundred bytes: as an Edgebreaker file the library would allocate
  // first.
  std::string bytes = write_with_library(*tetrahedron(), {.method = DracoMethod::Edgebreaker});
  const std::string huge = {'\xFF', '\xFF', '\xFF', '\xFF', '\x04'};  // 1.3 billion
  // After the header: kind of traversal, vertices, triangles.
  bytes.replace(13, 1, huge);
  EXPECT_EQ(cause_of(bytes), Cause::TooLarge);
  EXPECT_EQ(cause_of(bytes, {.max_triangles = ~std::uint64_t{0}}), Cause::TooLarge);
}

TEST(DracoHostile, HoldsItsLimitsAndNamesThem) {
  const std::string bytes = write_with_library(*seamed_sphere(), {});
  const auto document = decoded(bytes);
  ASSERT_NE(document, nullptr);
  const std::uint64_t points = document->positions().size(), triangles = document->triangles().size();
  const std::uint32_t attributes = 5;
  const std::pair<Limits, const char*> rows[] = {
      {{.max_bytes = bytes.size() - 1}, "(max-bytes)"},
      {{.max_vertices = points - 1}, "(max-vertices)"},
      {{.max_triangles = triangles - 1}, "(max-triangles)"},
      {{.max_attributes = attributes - 1}, "the mesh has 5 attributes; the limit is 4 (max-attributes)"},
  };
  for (const auto& [limits, says] : rows) {
    const auto refused = decode_draco(bytes, limits, kRun);
    ASSERT_FALSE(refused.ok()) << says;
    EXPECT_EQ(refused.error().cause, Cause::TooLarge);
    EXPECT_NE(refused.error().message.find(says), std::string::npos) << refused.error().message;
  }
  EXPECT_TRUE(decode_draco(bytes,
                           {.max_bytes = bytes.size(),
                            .max_vertices = points,
                            .max_triangles = triangles,
                            .max_attributes = attributes},
                           kRun)
                  .ok());
}

TEST(DracoHostile, PositionsOtherThanThreeFloatsAreNamed) {
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(3);
  mesh->AddFace({draco::PointIndex(0), draco::PointIndex(1), draco::PointIndex(2)});
  add_point_attribute<std::int32_t>(*mesh, DracoAttribute::POSITION, draco::DT_INT32, 3, false,
                                    {0, 0, 0, 1, 0, 0, 0, 1, 0});
  EXPECT_EQ(cause_of(write_with_library(*mesh, {})), Cause::UnsupportedFormat);
  add_point_attribute<float>(*mesh, DracoAttribute::POSITION, draco::DT_FLOAT32, 3, false,
                             {0, 0, 0, 1, 0, 0, 0, 1, 0});
  EXPECT_EQ(cause_of(write_with_library(*mesh, {})), Cause::UnsupportedFormat);
}

// Found by the fuzzer: 261 bytes kept the library busy for 3 s, because it believes any count of orientations
// of texture coordinates. Here every four bytes in turn claim 2^31 - 1 of something; one of them is that
// count.
TEST(DracoHostile, NoCountKeepsTheDecoderBusy) {
  const auto mesh = tetrahedron();
  add_point_attribute<float>(*mesh, DracoAttribute::TEX_COORD, draco::DT_FLOAT32, 2, false,
                             {0, 0, 1, 0, 0, 1, 1, 1});
  const WriteOptions options{
      .method = DracoMethod::Edgebreaker, .position_bits = 8, .texture_bits = 8, .speed = 0};
  const std::string bytes = write_with_library(*mesh, options);
  ASSERT_NE(decoded(bytes), nullptr);
  for (std::size_t at = 11; at + 4 <= bytes.size(); ++at) {
    std::string mutant = bytes;
    mutant.replace(at, 4, "\xFF\xFF\xFF\x7F");
    const std::clock_t start = std::clock();
    survive(mutant);
    EXPECT_LT(std::clock() - start, CLOCKS_PER_SEC) << at;
  }
}

// Found by the fuzzer: a method of prediction that does not exist went through our hands as an enum.
TEST(DracoHostile, AnUnknownPredictionIsADifference) {
  std::string bytes = write_with_library(*tetrahedron(), {.position_bits = 8});
  const auto is = decoded(bytes);
  ASSERT_NE(is, nullptr);
  constexpr std::size_t kMethod =
      kFirstIndex + 4 * 3 + 8;  // after the indices and one attribute's description
  ASSERT_EQ(bytes[kMethod], draco::PREDICTION_DIFFERENCE);
  ASSERT_EQ(bytes[kMethod + 1], draco::PREDICTION_TRANSFORM_WRAP);
  bytes[kMethod] = -64;
  const auto same = decoded(bytes);
  ASSERT_NE(same, nullptr);
  EXPECT_TRUE(std::ranges::equal(same->positions(), is->positions()));
}

// Found by the fuzzer: the library's conversion loads such bytes as bool, and 48 is neither true nor false.
TEST(DracoHostile, BytesThatPoseAsBoolAreNotConverted) {
  const auto mesh = tetrahedron();
  for (const auto type : {DracoAttribute::NORMAL, DracoAttribute::TEX_COORD, DracoAttribute::COLOR}) {
    const int components = type == DracoAttribute::TEX_COORD ? 2 : 3;
    const std::vector<std::uint8_t> values(static_cast<std::size_t>(4 * components), 48);
    add_point_attribute<std::uint8_t>(*mesh, type, draco::DT_BOOL, components, false, values);
  }
  const auto document = decoded(write_with_library(*mesh, {}));
  ASSERT_NE(document, nullptr);
  const Moved moved(*document);
  const auto shared = document->shared_attributes(moved.view(), kRun);
  ASSERT_TRUE(shared.ok());
  EXPECT_EQ(shared->dropped,
            (std::vector<std::string>{"normals 1 (3 components)", "texture coordinates 2 (2 components)",
                                      "colours 3 (3 components)"}));
  EXPECT_TRUE(document->encode_same(moved.view(), {}, kRun).ok());
}

TEST(DracoHostile, StopAndDeadlineEndTheDecoding) {
  const std::string bytes = write_with_library(*tetrahedron(), {});
  std::stop_source stop;
  stop.request_stop();
  const auto cancelled = decode_draco(bytes, Limits{}, {.stop = stop.get_token()});
  ASSERT_FALSE(cancelled.ok());
  EXPECT_EQ(cancelled.error().cause, Cause::Cancelled);
  const auto late = decode_draco(bytes, Limits{}, {.deadline = RunControl::Clock::now()});
  ASSERT_FALSE(late.ok());
  EXPECT_EQ(late.error().cause, Cause::DeadlineExceeded);
}

}  // namespace
}  // namespace burnish::testing
