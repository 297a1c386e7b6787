// GLB files that no writer wrote.
#include <random>

#include "tests/core/glb_fixture.h"

namespace burnish::testing {
namespace {

using Json = nlohmann::ordered_json;

TestGlb small() {
  TestGlb glb;
  glb.mesh(sphere(0), "ball");
  return glb;
}

/// The error that a change to the JSON of a good file brings.
template <class Change>
Error after(Change change) {
  TestGlb glb = small();
  glb.json["buffers"] = {{{"byteLength", glb.bin.size()}}};
  change(glb.json);
  return glb_error(to_glb(glb.json.dump(), glb.bin));
}

void expect_error(const Error& error, Cause cause, std::string_view says) {
  EXPECT_EQ(error.cause, cause) << error.message;
  EXPECT_NE(error.message.find(says), std::string::npos) << error.message;
}

TEST(GlbHostile, EveryTruncatedPrefixIsAnError) {
  const std::string bytes = small().bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // A copy of its own size, so that the sanitizers see a read beyond the end.
    const std::vector<char> prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(glb_error({prefix.data(), prefix.size()}).cause, Cause::MalformedMesh) << size;
    // The same with a header that tells the new length: then a chunk is cut, or something that the JSON
    // cites.
    if (size < 12) continue;
    std::string honest = bytes.substr(0, size);
    const auto length = static_cast<std::uint32_t>(size);
    std::memcpy(honest.data() + 8, &length, 4);
    EXPECT_EQ(glb_error(honest).cause, Cause::MalformedMesh) << size;
  }
}

TEST(GlbHostile, LengthsAndVersionsThatLieAreNamed) {
  const std::string good = small().bytes();
  const auto with = [&](std::size_t at, std::uint32_t word) {
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &word, 4);
    return glb_error(bytes);
  };
  expect_error(with(4, 1), Cause::UnsupportedFormat, "version 1");
  expect_error(with(8, 7), Cause::MalformedMesh, "declares 7 bytes in its header");
  expect_error(with(8, 0xFFFFFFFF), Cause::MalformedMesh, "cut short");
  expect_error(with(12, 0xFFFFFFFF), Cause::MalformedMesh, "JSON chunk declares 4294967295 bytes");
  expect_error(with(16, 7), Cause::MalformedMesh, "first chunk");
}

TEST(GlbHostile, NumbersOutsideTheirRangeAreNamed) {
  const auto number = [](const char* list, const char* name, Json value) {
    return after([&](Json& json) { json[list][0][name] = value; });
  };
  expect_error(number("accessors", "count", -1), Cause::MalformedMesh,
               "accessors[0].count must be a whole number");
  expect_error(number("accessors", "count", 1.5), Cause::MalformedMesh,
               "accessors[0].count must be a whole number");
  expect_error(number("accessors", "count", "7"), Cause::MalformedMesh,
               "accessors[0].count must be a whole number");
  expect_error(number("accessors", "count", 0), Cause::MalformedMesh, "at least 1");
  expect_error(number("accessors", "count", 1000000000), Cause::MalformedMesh, "has 1000000000 rows");
  expect_error(number("accessors", "count", 4294967295), Cause::MalformedMesh, "has 4294967295 rows");
  expect_error(number("accessors", "count", 1e300), Cause::MalformedMesh, "must be a whole number");
  expect_error(number("accessors", "byteOffset", 4294967295), Cause::MalformedMesh, "end at byte 4294967439");
  expect_error(number("accessors", "byteOffset", 18446744073709551615U), Cause::MalformedMesh,
               "whole number");
  expect_error(number("accessors", "componentType", 5124), Cause::MalformedMesh, "5124");
  expect_error(number("accessors", "type", "MAT4"), Cause::MalformedMesh, "accessors[0].type");
  expect_error(number("accessors", "type", "VEC2"), Cause::MalformedMesh, "must be VEC3");
  expect_error(number("accessors", "bufferView", 99), Cause::MalformedMesh, "cites bufferViews[99] of 3");
  expect_error(number("bufferViews", "byteLength", 4294967295), Cause::MalformedMesh,
               "bufferViews[0] ends at byte");
  expect_error(number("bufferViews", "byteStride", 4), Cause::MalformedMesh,
               "rows of 12 bytes in steps of 4");
  expect_error(number("bufferViews", "byteStride", 4294967295), Cause::MalformedMesh, "rows");
  expect_error(number("bufferViews", "buffer", 1), Cause::MalformedMesh, "cites buffers[1] of 1");
  expect_error(number("buffers", "byteLength", 4294967295), Cause::MalformedMesh,
               "buffers[0] declares 4294967295 bytes");
  expect_error(after([](Json& json) { json["meshes"][0]["primitives"][0]["mode"] = 7; }),
               Cause::MalformedMesh, "mode is 7");
  expect_error(after([](Json& json) { json["meshes"][0]["primitives"][0]["indices"] = 77; }),
               Cause::MalformedMesh, "the indices of mesh 0 \"ball\", primitive 0 cites accessors[77] of 3");
  expect_error(after([](Json& json) { json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2; }),
               Cause::MalformedMesh, "12 positions and 60 normals");
  expect_error(after([](Json& json) { json["meshes"] = Json::array({Json::object()}); }),
               Cause::MalformedMesh, "no primitives");
  expect_error(after([](Json& json) { json.erase("meshes"); }), Cause::EmptyMesh, "no mesh");
  expect_error(after([](Json& json) { json.erase("asset"); }), Cause::MalformedMesh, "asset.version");
  expect_error(after([](Json& json) { json["asset"]["version"] = "1.0"; }), Cause::UnsupportedFormat, "1.0");
}

TEST(GlbHostile, WhatCannotBeReadIsRefusedInASentence) {
  expect_error(after([](Json& json) {
                 json["accessors"][0]["sparse"] = {{"count", 1}};
               }),
               Cause::UnsupportedFormat, "sparse");
  expect_error(after([](Json& json) { json["accessors"][0].erase("bufferView"); }), Cause::UnsupportedFormat,
               "no bufferView");
  expect_error(after([](Json& json) { json["buffers"][0]["uri"] = "scan of Tuesday.bin"; }),
               Cause::UnsupportedFormat, "buffers[0] (\"scan of Tuesday.bin\") is another file");
  expect_error(
      after([](Json& json) { json["buffers"][0]["uri"] = "data:application/octet-stream;base64,AA=*"; }),
      Cause::MalformedMesh, "no base64");
  expect_error(after([](Json& json) {
                 json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0}};
               }),
               Cause::UnsupportedFormat, "EXT_meshopt_compression");
}

TEST(GlbHostile, IndicesOutOfRangeNameMeshPrimitiveTriangleAndVertex) {
  TestGlb glb;
  const int position = glb.positions(float_positions(sphere(0)));
  const int index = glb.indices(std::vector<std::uint16_t>{0, 1, 2, 3, 4, 12});
  glb.mesh({{{"attributes", {{"POSITION", position}}}, {"indices", index}}}, "ball");
  const Error error = glb_error(glb.bytes());
  EXPECT_EQ(error.cause, Cause::IndexOutOfRange);
  EXPECT_EQ(error.message, "mesh 0 \"ball\", primitive 0: triangle 1 uses vertex 12 of 12");
}

TEST(GlbHostile, PositionsThatAreNoNumbersAreNamed) {
  TestGlb glb = small();
  const float nan = std::nanf("");
  std::memcpy(glb.bin.data() + 12 * 5 + 4, &nan, 4);
  const Error error = glb_error(glb.bytes());
  EXPECT_EQ(error.cause, Cause::NonFinitePosition);
  EXPECT_EQ(error.message, "vertex 5 of mesh 0 \"ball\", primitive 0: coordinate y is not a finite number");
}

TEST(GlbHostile, JsonIsBoundedInDepthAndSizeAndReadStrictly) {
  const auto error_of = [](const std::string& json) { return glb_error(to_glb(json, std::nullopt)); };
  const std::string asset = R"({"asset":{"version":"2.0"})";
  expect_error(error_of(""), Cause::MalformedMesh, "JSON");
  expect_error(error_of("[]"), Cause::MalformedMesh, "no object");
  expect_error(error_of(asset), Cause::MalformedMesh, "malformed at byte");
  expect_error(error_of(asset + ",}"), Cause::MalformedMesh, "malformed at byte");
  expect_error(error_of(asset + ",\"nodes\":\"\xC3\x28\"}"), Cause::MalformedMesh, "malformed at byte");
  expect_error(error_of(asset + ",\"asset\":{}}"), Cause::MalformedMesh, "names \"asset\" twice");
  expect_error(error_of(asset + ",\"\\u0061sset\":{}}"), Cause::MalformedMesh, "names \"asset\" twice");
  expect_error(error_of(asset + std::string(",\0", 2) + "}"), Cause::MalformedMesh, "NUL");
  expect_error(error_of(asset + ",\"nodes\":1e999}"), Cause::MalformedMesh, "too large");
  for (const std::string name : {"meshes", "extras", "whatever"}) {
    const std::string deep =
        asset + ",\"" + name + "\":" + std::string(1'000'000, '[') + std::string(1'000'000, ']') + '}';
    expect_error(error_of(deep), Cause::TooLarge, "deeper than 64");
  }
  std::string many = asset + ",\"nodes\":[0";
  for (int i = 0; i < 1'000'001; ++i) many += ",0";
  expect_error(error_of(many + "]}"), Cause::TooLarge, "more than 1000000 values");
  // What only carries through may be as large as it likes.
  std::string carried = asset + ",\"extras\":[0";
  for (int i = 0; i < 1'000'001; ++i) carried += ",0";
  EXPECT_EQ(error_of(carried + "]}").cause, Cause::EmptyMesh);
}

TEST(GlbHostile, PositionsThatShareBytesWithSomethingElseAreRefused) {
  const auto share = [](const char* of, int offset) {
    TestGlb glb;
    const bool zeros = std::string_view(of) == "indices";
    const int position = glb.positions(zeros ? std::vector<Vec3f>(12) : float_positions(sphere(0)));
    Json primitive = {{"attributes", {{"POSITION", position}}}};
    if (std::string_view(of) == "normals") {
      primitive["attributes"]["NORMAL"] = position;
    } else if (zeros) {
      glb.bin += std::string(400, '\0');
      glb.json["bufferViews"][0]["byteLength"] = 400;
      primitive["indices"] = glb.accessor(0, 140, 30, kGlbUInt8, "SCALAR");
    } else {
      glb.json["accessors"][0]["count"] = 6;
      const int other = glb.accessor(0, static_cast<std::size_t>(offset), 6, kGlbFloat, "VEC3");
      glb.mesh(Json::array({primitive}));
      primitive["attributes"]["POSITION"] = other;
    }
    glb.mesh(Json::array({primitive}));
    return glb.bytes();
  };
  for (const char* const of : {"normals", "indices"})
    expect_error(glb_error(share(of, 0)), Cause::MalformedMesh, "share bytes");
  expect_error(glb_error(share("positions", 4)), Cause::MalformedMesh, "share bytes");
  // Whole rows may be cited twice; they then move as one, also across meshes.
  const std::string bytes = share("positions", 36);
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const MovedGlb moved(*document);
  EXPECT_EQ(moved.surface.weld[3], moved.surface.weld[6]);
}

TEST(GlbHostile, HoldsItsLimitsAndNamesThem) {
  const std::string bytes = small().bytes();
  expect_error(glb_error(bytes, {.max_vertices = 11}), Cause::TooLarge, "(max-vertices)");
  expect_error(glb_error(bytes, {.max_triangles = 19}), Cause::TooLarge, "(max-triangles)");
  EXPECT_TRUE(decode_glb(bytes, {.max_vertices = 12, .max_triangles = 20}, {}).ok());
  // A thousand primitives of the same rows.
  TestGlb glb = small();
  for (int i = 0; i < 1000; ++i)
    glb.json["meshes"][0]["primitives"].push_back(glb.json["meshes"][0]["primitives"][0]);
  expect_error(glb_error(glb.bytes(), {.max_triangles = 1000}), Cause::TooLarge, "(max-triangles)");
}

TEST(GlbHostile, StopAndDeadlineEndTheDecoding) {
  const std::string bytes = small().bytes();
  std::stop_source stop;
  stop.request_stop();
  const auto cancelled = decode_glb(bytes, Limits{}, {.stop = stop.get_token()});
  ASSERT_FALSE(cancelled.ok());
  EXPECT_EQ(cancelled.error().cause, Cause::Cancelled);
  const auto late = decode_glb(bytes, Limits{}, {.deadline = RunControl::Clock::now()});
  ASSERT_FALSE(late.ok());
  EXPECT_EQ(late.error().cause, Cause::DeadlineExceeded);
  const auto document = decoded_glb(bytes);
  const MovedGlb moved = MovedGlb(*document).shake();
  const auto encoded = document->encode_same(moved.view(), {}, {.stop = stop.get_token()});
  ASSERT_FALSE(encoded.ok());
  EXPECT_EQ(encoded.error().cause, Cause::Cancelled);
}

TEST(GlbHostile, FlippedBytesNeverCrash) {
  std::mt19937 random(20250612);
  TestGlb glb = small();
  glb.mesh(sphere(0));
  const std::string bytes = glb.bytes();
  std::size_t accepted = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string mutant = bytes;
    for (int flips = 0; flips < 1 + round % 4; ++flips)
      mutant[20 + random() % (mutant.size() - 20)] = static_cast<char>(random());
    const auto document = decode_glb(mutant, Limits{}, {});
    if (!document.ok()) continue;
    ++accepted;
    const MovedGlb moved = MovedGlb(**document).shake();
    const auto encoded = encode(**document, moved.view(), {}, {});
    if (encoded.ok()) {
      const auto again = decode_glb(encoded->bytes, Limits{}, {});
      EXPECT_TRUE(again.ok()) << (again.ok() ? "" : again.error().message);
    }
  }
  EXPECT_GT(accepted, 100U);
}

}  // namespace
}  // namespace burnish::testing
