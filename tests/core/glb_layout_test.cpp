// The ways in which a GLB may lay out its triangles and numbers.
#include "tests/core/glb_fixture.h"

namespace burnish::testing {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Triangle> triangles_of(const TestGlb& glb) {
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  if (document == nullptr) return {};
  return {document->triangles().begin(), document->triangles().end()};
}

TEST(GlbLayout, ReadsListsStripsAndFansWithEachTypeOfIndex) {
  const std::vector<Vec3f> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}};
  const std::vector<Triangle> expected[] = {{{0, 1, 2}, {3, 4, 5}},
                                            {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}},
                                            {{1, 2, 0}, {2, 3, 0}, {3, 4, 0}, {4, 5, 0}}};
  for (int mode = 4; mode <= 6; ++mode) {
    for (int bytes = 0; bytes <= 4; bytes = bytes == 0 ? 1 : 2 * bytes) {
      TestGlb glb;
      Json primitive = {{"attributes", {{"POSITION", glb.positions(points)}}}, {"mode", mode}};
      if (bytes == 1) primitive["indices"] = glb.indices(std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5});
      if (bytes == 2) primitive["indices"] = glb.indices(std::vector<std::uint16_t>{0, 1, 2, 3, 4, 5});
      if (bytes == 4) primitive["indices"] = glb.indices(std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5});
      glb.mesh(Json::array({primitive}));
      EXPECT_EQ(triangles_of(glb), expected[mode - 4]) << "mode " << mode << ", " << bytes << " bytes";
    }
  }
}

TEST(GlbLayout, InterleavedRowsKeepWhatStandsBetween) {
  const Shape shape = sphere(2);
  const auto positions = float_positions(shape), normals = directions(shape);
  std::string rows = "head";
  for (std::size_t v = 0; v < positions.size(); ++v) {
    rows.append(reinterpret_cast<const char*>(&positions[v]), 12).append(8, static_cast<char>(v));
    rows.append(reinterpret_cast<const char*>(&normals[v]), 12).append("keep");
  }
  TestGlb glb;
  const int view = glb.view(rows, 36);
  const int position = glb.accessor(view, 4, positions.size(), kGlbFloat, "VEC3");
  const int normal = glb.accessor(view, 24, positions.size(), kGlbFloat, "VEC3");
  // 36 bytes a row, the last row cut at its end: the view ends with "keep".
  glb.mesh({{{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
             {"indices", glb.indices(indices_of<std::uint32_t>(shape))}}});
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  MovedGlb moved(*document);
  const GlbChunks before = split_glb(bytes), after = split_glb(moved.shake().encoded().bytes);
  EXPECT_EQ(after.json, before.json);  // without bounds nothing changes there
  ASSERT_EQ(after.bin.size(), before.bin.size());
  EXPECT_EQ(after.bin.substr(0, 4), "head");
  for (Index v = 0; v < positions.size(); ++v) {
    const std::size_t at = 4 + 36 * v;
    EXPECT_EQ(value_at<Vec3f>(after.bin, at), moved.wanted(v));
    EXPECT_EQ(after.bin.substr(at + 12, 8), before.bin.substr(at + 12, 8));
    EXPECT_NE(after.bin.substr(at + 20, 12), before.bin.substr(at + 20, 12));
    EXPECT_EQ(after.bin.substr(at + 32, 4), "keep");
  }
  EXPECT_EQ(after.bin.substr(rows.size()), before.bin.substr(rows.size()));
}

TEST(GlbLayout, PrimitivesThatShareTheirRowsMoveThemOnce) {
  const Shape shape = sphere(2);
  TestGlb glb;
  const int position = glb.positions(float_positions(shape)), normal = glb.vectors(directions(shape));
  Shape halves[2] = {shape, shape};
  const auto middle = static_cast<std::ptrdiff_t>(shape.triangles.size() / 2);
  halves[0].triangles.resize(shape.triangles.size() / 2);
  halves[1].triangles.erase(halves[1].triangles.begin(), halves[1].triangles.begin() + middle);
  Json primitives;
  for (const Shape& half : halves) {
    primitives.push_back({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
                          {"indices", glb.indices(indices_of<std::uint16_t>(half))}});
  }
  glb.mesh(primitives);
  TestGlb one;
  one.mesh(shape);
  const std::string bytes = glb.bytes(), plain = one.bytes();
  const auto document = decoded_glb(bytes), same = decoded_glb(plain);
  ASSERT_TRUE(document != nullptr && same != nullptr);
  EXPECT_EQ(document->positions().size(), shape.positions.size());
  EXPECT_TRUE(std::ranges::equal(document->triangles(), same->triangles()));
  const std::string split = split_glb(MovedGlb(*document).shake().encoded().bytes).bin;
  const std::string whole = split_glb(MovedGlb(*same).shake().encoded().bytes).bin;
  const std::size_t vectors = 24 * shape.positions.size();
  EXPECT_EQ(split.substr(0, vectors), whole.substr(0, vectors));
}

TEST(GlbLayout, QuantisedPositionsStayOnTheirGridAndTheErrorIsTold) {
  const Shape shape = scaled(sphere(2), 0.9);
  for (const bool normalized : {true, false}) {
    TestGlb glb;
    std::string rows;
    for (const Vec3d& p : shape.positions) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto value = static_cast<std::int16_t>(std::round(p[axis] * 32767));
        rows.append(reinterpret_cast<const char*>(&value), 2);
      }
      rows.append("##");
    }
    const int position = glb.accessor(glb.view(rows, 8), 0, shape.positions.size(), kGlbInt16, "VEC3");
    glb.json["accessors"][0]["normalized"] = normalized;
    glb.json["accessors"][0]["min"] = {-29490, -29490, -29490};
    glb.json["accessors"][0]["max"] = {29490, 29490, 29490};
    std::string turned;
    for (const Vec3f& n : directions(shape)) {
      for (std::size_t axis = 0; axis < 3; ++axis) turned += static_cast<char>(std::round(n[axis] * 127));
      turned += '#';
    }
    const int normal = glb.accessor(glb.view(turned, 4), 0, shape.positions.size(), kGlbInt8, "VEC3");
    glb.json["accessors"][1]["normalized"] = true;
    glb.mesh({{{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
               {"indices", glb.indices(indices_of<std::uint16_t>(shape))}}});
    const std::string bytes = glb.bytes();
    const auto document = decoded_glb(bytes);
    ASSERT_NE(document, nullptr);
    const double unit = normalized ? 1.0 / 32767 : 1;
    EXPECT_NEAR(length(document->positions()[0]), 0.9 * 32767 * unit, 2 * unit);
    MovedGlb moved(*document);
    const Encoded encoded = moved.shake(0.02f).encoded();
    EXPECT_GT(encoded.quantisation_error, 0.3 * unit);
    EXPECT_LE(encoded.quantisation_error, std::sqrt(3.0) / 2 * unit * 1.0001);
    const GlbChunks after = split_glb(encoded.bytes);
    int low = 40000;
    for (Index v = 0; v < shape.positions.size(); ++v) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto value = value_at<std::int16_t>(after.bin, 8 * v + 2 * axis);
        EXPECT_EQ(value, std::round(moved.view().at(v)[axis] / unit));
        if (axis == 0) low = std::min<int>(low, value);
      }
      EXPECT_EQ(after.bin.substr(8 * v + 6, 2), "##");
    }
    const auto bounds = nlohmann::json::parse(after.json)["accessors"][0];
    EXPECT_TRUE(bounds["min"][0].is_number_integer());
    EXPECT_EQ(bounds["min"][0].get<int>(), low);
    const auto again = decoded_glb(encoded.bytes);
    ASSERT_NE(again, nullptr);
  }
}

TEST(GlbLayout, WhatIntegersCannotHoldIsHeldBackWithAWarning) {
  TestGlb glb;
  const Shape shape = sphere(1);
  std::vector<std::int8_t> rows;
  for (const Vec3d& p : shape.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows.push_back(static_cast<std::int8_t>(std::round(127 * p[axis])));
  }
  const int position = glb.accessor(glb.view(bytes_of(rows)), 0, shape.positions.size(), kGlbInt8, "VEC3");
  glb.mesh({{{"attributes", {{"POSITION", position}}},
             {"indices", glb.indices(indices_of<std::uint8_t>(shape))}}});
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  MovedGlb moved(*document);
  for (Vec3f& p : moved.after) p *= 1.5f;
  const Encoded encoded = moved.encoded();
  ASSERT_NE(find_warning(encoded, "quantisation_range_left"), nullptr);
  EXPECT_GT(encoded.quantisation_error, 50);
}

TEST(GlbLayout, BuffersInDataUrisAreReadAndWrittenBack) {
  // Three points in base64: 36 bytes are 48 letters.
  TestGlb glb;
  const std::vector<Vec3f> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  glb.mesh({{{"attributes", {{"POSITION", glb.positions(points)}}}}});
  glb.json["buffers"] = Json::array(
      {{{"uri", "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"},
        {"byteLength", 36}}});
  const std::string bytes = to_glb(glb.json.dump(), std::nullopt);
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(document->positions()[1], (Vec3d{1, 0, 0}));
  MovedGlb moved(*document);
  moved.shake();
  const std::string out = moved.encoded().bytes;
  const auto again = decoded_glb(out);
  ASSERT_NE(again, nullptr);
  for (Index v = 0; v < 3; ++v) EXPECT_EQ(to_float(again->positions()[v]), moved.wanted(v));
  EXPECT_EQ(MovedGlb(*document).encoded().bytes, bytes);
}

TEST(GlbLayout, BoundsAreThoseOfEveryRowAlsoOfRowsThatNoTriangleUses) {
  TestGlb glb;
  Shape shape = sphere(1);
  shape.positions.push_back({5, -6, 7});
  const int position = glb.positions(float_positions(shape));
  glb.mesh({{{"attributes", {{"POSITION", position}}},
             {"indices", glb.indices(indices_of<std::uint16_t>(shape))}}});
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  MovedGlb moved(*document);
  moved.shake(0.01f, [](const Vec3d& p) { return p.x > 4; });
  const auto json = nlohmann::json::parse(split_glb(moved.encoded().bytes).json);
  EXPECT_EQ(json["accessors"][0]["max"][0], 5);
  EXPECT_EQ(json["accessors"][0]["min"][1], -6);
  EXPECT_EQ(json["accessors"][0]["max"][2], 7);
}

TEST(GlbLayout, NormalsThatSeveralSetsOfPositionsShareStay) {
  TestGlb glb;
  const Shape shape = sphere(1);
  const int normal = glb.vectors(directions(shape)), index = glb.indices(indices_of<std::uint16_t>(shape));
  for (int mesh = 0; mesh < 2; ++mesh) {
    glb.mesh({{{"attributes", {{"POSITION", glb.positions(float_positions(shape))}, {"NORMAL", normal}}},
               {"indices", index}}});
  }
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const Encoded encoded = MovedGlb(*document).shake().encoded();
  ASSERT_NE(find_warning(encoded, "normals_not_recomputed"), nullptr);
  EXPECT_EQ(split_glb(encoded.bytes).bin.substr(0, 12 * shape.positions.size()), bytes_of(directions(shape)));
}

}  // namespace
}  // namespace burnish::testing
