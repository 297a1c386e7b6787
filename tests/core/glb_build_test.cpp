// GLB from other formats and into them.
#include "core/io/draco.h"
#include "tests/core/glb_fixture.h"

namespace burnish::testing {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kObj =
    "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\n"
    "vt 0 0\nvt 1 0\nvt 0.25 0.75\nvn 0 0 -2\nvn 0 -1 0\nvn 0.6 0.8 0\n"
    "f 1/1/1 3/2/1 2/3/1\nf 1/1/2 2/2/2 4/3/2\nf 2/1/3 3/2/3 4/3/3\nf 3/1/3 1/2/3 4/3/3\n";

std::string converted(std::string_view bytes, Format to, Encoded* encoded = nullptr) {
  const auto document = decode(bytes, std::nullopt, {}, {});
  EXPECT_TRUE(document.ok()) << (document.ok() ? "" : document.error().message);
  if (!document.ok()) return {};
  Encoded result = MovedGlb(**document).encoded({.format = to});
  if (encoded != nullptr) *encoded = result;
  return result.bytes;
}

TEST(GlbBuild, WritesWhatAnObjHoldsSplitAtItsSeams) {
  Encoded encoded;
  const std::string bytes = converted(kObj, Format::Glb, &encoded);
  EXPECT_EQ(encoded.quantisation_error, 0);
  EXPECT_EQ(encoded.triangles, 4U);
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(document->positions().size(), encoded.vertices);
  EXPECT_GT(document->positions().size(), 4U);
  const MovedGlb moved(*document);
  EXPECT_EQ(moved.surface.mesh.positions.size(), 4U);
  const auto shared = document->shared_attributes(moved.view(), {});
  ASSERT_TRUE(shared.ok());
  ASSERT_TRUE(shared->normals && shared->texture_coordinates);
  const auto at = [](const MeshAttribute& attribute, std::size_t t, std::size_t corner) {
    const auto n = static_cast<std::size_t>(attribute.components);
    const float* const row = &attribute.values[n * attribute.corners[t][corner]];
    return std::vector<float>(row, row + n);
  };
  EXPECT_EQ(at(*shared->normals, 0, 0), (std::vector<float>{0, 0, -1}));  // of unit length now
  EXPECT_EQ(at(*shared->normals, 1, 0), (std::vector<float>{0, -1, 0}));
  EXPECT_EQ(at(*shared->texture_coordinates, 0, 2), (std::vector<float>{0.25f, 0.75f}));
  EXPECT_EQ((std::vector<float>(shared->colors.begin(), shared->colors.begin() + 12)),
            (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_TRUE(shared->dropped.empty());
}

TEST(GlbBuild, TextureCoordinatesCountFromTheTop) {
  const std::string bytes = converted(kObj, Format::Glb);
  const GlbChunks chunks = split_glb(bytes);
  const auto json = nlohmann::json::parse(chunks.json);
  const auto& accessor =
      json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"].get<std::size_t>()];
  const auto offset =
      json["bufferViews"][accessor["bufferView"].get<std::size_t>()]["byteOffset"].get<std::size_t>();
  EXPECT_EQ(value_at<float>(chunks.bin, offset + 4), 1);              // vt 0 0
  EXPECT_EQ(value_at<float>(chunks.bin, offset + 8 + 4), 1 - 0.75f);  // the second vertex: vt 0.25 0.75
}

TEST(GlbBuild, ThroughGlbAndBackAnObjKeepsItsShape) {
  const std::string back = converted(converted(kObj, Format::Glb), Format::Obj);
  const auto before = decode(kObj, Format::Obj, {}, {}), after = decode(back, Format::Obj, {}, {});
  ASSERT_TRUE(before.ok() && after.ok());
  for (std::size_t t = 0; t < 4; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ((*after)->positions()[(*after)->triangles()[t][c]],
                (*before)->positions()[(*before)->triangles()[t][c]]);
    }
  }
  EXPECT_NE(back.find("vt 0.25"), std::string::npos);
}

TEST(GlbBuild, ColorsThatAreNoBytesStayFloats) {
  const std::string obj = "v 0 0 0 0.123 0.5 1\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n";
  const std::string glb = converted(obj, Format::Glb);
  const auto document = decoded_glb(glb);
  ASSERT_NE(document, nullptr);
  const auto shared = document->shared_attributes(MovedGlb(*document).view(), {});
  ASSERT_TRUE(shared.ok());
  ASSERT_EQ(shared->colors.size(), 9U);
  EXPECT_EQ(shared->colors[0], 0.123f);
}

TEST(GlbBuild, ManyVerticesTakeLongIndices) {
  const Shape shape = grid(260);
  ASSERT_GT(shape.positions.size(), 65536U);
  const std::string bytes = converted(to_obj(shape), Format::Glb);
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  EXPECT_TRUE(std::ranges::equal(document->triangles(), shape.triangles));
  const auto json = nlohmann::json::parse(split_glb(bytes).json);
  EXPECT_EQ(json["accessors"].back()["componentType"], kGlbUInt32);
}

TEST(GlbBuild, SaysWhatOtherFormatsCannotCarry) {
  TestGlb glb;
  const Shape shape = sphere(1);
  const int position = glb.positions(float_positions(shape));
  glb.mesh({{{"attributes", {{"POSITION", position}, {"_HEAT", position}}},
             {"indices", glb.indices(indices_of<std::uint16_t>(shape))}}});
  glb.json["materials"] = Json::array({Json::object()});
  glb.json["nodes"] = {{{"mesh", 0}, {"scale", {2, 2, 2}}}};
  Encoded encoded;
  converted(glb.bytes(), Format::Obj, &encoded);
  ASSERT_EQ(encoded.warnings.size(), 1U);
  EXPECT_EQ(encoded.warnings[0].message,
            "the other format cannot carry: materials; the nodes that place the meshes; \"_HEAT\"");
}

TEST(GlbBuild, FarCoordinatesAreRoundedAndTheErrorIsTold) {
  Encoded encoded;
  converted(to_obj(moved(sphere(2), {1e6, 2e6, 0})), Format::Glb, &encoded);
  EXPECT_GT(encoded.quantisation_error, 0.01);
  EXPECT_LT(encoded.quantisation_error, 0.2);
}

TEST(GlbBuild, BeyondFloatsIsAnError) {
  const std::string obj = "v 0 0 0\nv 1e50 0 0\nv 0 1e50 0\nf 1 2 3\n";
  const auto document = decode(obj, Format::Obj, {}, {});
  ASSERT_TRUE(document.ok());
  const auto encoded = encode(**document, MovedGlb(**document).view(), {.format = Format::Glb}, {});
  ASSERT_FALSE(encoded.ok());
  EXPECT_EQ(encoded.error().cause, Cause::CannotEncode);
}

}  // namespace
}  // namespace burnish::testing
