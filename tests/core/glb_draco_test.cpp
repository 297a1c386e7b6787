// KHR_draco_mesh_compression: decoded, smoothed, written anew with the same ids, method and grid.
#include <algorithm>

#include "tests/core/draco_fixture.h"
#include "tests/core/glb_fixture.h"

namespace burnish::testing {
namespace {

using Json = nlohmann::ordered_json;

/// The sphere of the Draco tests within a GLB, between other views.
struct CompressedFile {
  TestGlb glb;
  int view = 0;

  explicit CompressedFile(const WriteOptions& options) {
    const auto mesh = seamed_sphere();
    const std::string drc = write_with_library(*mesh, options);
    const auto points = static_cast<std::size_t>(decoded(drc)->positions().size());
    glb.view("before, untouched");
    view = glb.view(drc);
    glb.view("behind, moved");
    const auto declare = [&](const char* type, std::size_t count, int component) {
      glb.json["accessors"].push_back({{"componentType", component}, {"count", count}, {"type", type}});
      return static_cast<int>(glb.json["accessors"].size()) - 1;
    };
    const int position = declare("VEC3", points, kGlbFloat), normal = declare("VEC3", points, kGlbFloat),
              texture = declare("VEC2", points, kGlbFloat), color = declare("VEC3", points, kGlbUInt8),
              index = declare("SCALAR", 3 * mesh->num_faces(), kGlbUInt16);
    glb.json["accessors"][0]["min"] = {-1, -1, -1};
    glb.json["accessors"][0]["max"] = {1, 1, 1};
    glb.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
    glb.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    const auto id = [&](DracoAttribute::Type type) { return mesh->GetNamedAttribute(type)->unique_id(); };
    const Json extension = {{"bufferView", view},
                            {"attributes",
                             {{"POSITION", id(DracoAttribute::POSITION)},
                              {"NORMAL", id(DracoAttribute::NORMAL)},
                              {"TEXCOORD_0", id(DracoAttribute::TEX_COORD)},
                              {"COLOR_0", id(DracoAttribute::COLOR)}}}};
    glb.mesh(Json::array(
        {{{"attributes",
           {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", texture}, {"COLOR_0", color}}},
          {"indices", index},
          {"extensions", {{"KHR_draco_mesh_compression", extension}}}}}));
  }
};

std::string view_bytes(const GlbChunks& chunks, std::size_t number) {
  const auto view = nlohmann::json::parse(chunks.json)["bufferViews"][number];
  return chunks.bin.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
}

TEST(GlbDraco, KeepsAttributesIdsMethodAndGrid) {
  for (const auto method : kMethods) {
    CompressedFile file({.method = method, .position_bits = 12, .normal_bits = 10, .texture_bits = 12});
    const std::string bytes = file.glb.bytes();
    const auto document = decoded_glb(bytes);
    ASSERT_NE(document, nullptr);
    MovedGlb moved(*document);
    for (Vec3f& p : moved.after) p *= 0.98f;  // within the grid
    const Encoded encoded = moved.encoded();
    EXPECT_EQ(encoded.draco_method, method);
    EXPECT_EQ(encoded.position_bits, 12);
    EXPECT_GT(encoded.quantisation_error, 0);
    EXPECT_LT(encoded.quantisation_error, 2.5 / 4095);
    EXPECT_EQ(find_warning(encoded, "order_not_kept") != nullptr, method == DracoMethod::Edgebreaker);

    const GlbChunks before = split_glb(bytes), after = split_glb(encoded.bytes);
    EXPECT_EQ(view_bytes(after, 0), "before, untouched");
    EXPECT_EQ(view_bytes(after, 2), "behind, moved");
    const auto is = read_with_library(view_bytes(after, 1)), was = read_with_library(view_bytes(before, 1));
    ASSERT_EQ(is->num_attributes(), was->num_attributes());
    for (int a = 0; a < was->num_attributes(); ++a) {
      EXPECT_EQ(is->attribute(a)->unique_id(), was->attribute(a)->unique_id());
    }
    const auto json = nlohmann::json::parse(after.json);
    for (std::size_t a = 0; a < 4; ++a) EXPECT_EQ(json["accessors"][a]["count"], is->num_points());
    EXPECT_EQ(json["accessors"][4]["count"], 3 * is->num_faces());
    EXPECT_EQ(json["buffers"][0]["byteLength"].get<std::size_t>() + 3 >= after.bin.size(), true);
    const auto again = decoded_glb(encoded.bytes);
    ASSERT_NE(again, nullptr);
    Vec3d low = again->positions()[0], high = low;
    for (const Vec3d& p : again->positions()) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(json["accessors"][0]["min"][axis].get<double>(), low[axis]);
      EXPECT_EQ(json["accessors"][0]["max"][axis].get<double>(), high[axis]);
    }
    if (method == DracoMethod::Sequential) {
      for (Index v = 0; v < again->positions().size(); ++v) {
        EXPECT_LE(length(again->positions()[v] - moved.view().at(v)), encoded.quantisation_error + 1e-12);
      }
    }
  }
}

TEST(GlbDraco, WhatDoesNotMoveIsTheSameFile) {
  for (const auto method : kMethods) {
    const std::string bytes = CompressedFile({.method = method, .position_bits = 11}).glb.bytes();
    const auto document = decoded_glb(bytes);
    ASSERT_NE(document, nullptr);
    const Encoded encoded = MovedGlb(*document).encoded();
    EXPECT_EQ(encoded.bytes, bytes);
    EXPECT_EQ(encoded.position_bits, 11);
    EXPECT_EQ(encoded.draco_method, method);
  }
}

TEST(GlbDraco, OptionsAreFollowed) {
  const std::string bytes =
      CompressedFile({.method = DracoMethod::Sequential, .position_bits = 11}).glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  OutputOptions options;
  options.draco = {.method = DracoMethod::Edgebreaker, .position_bits = 16};
  const Encoded encoded = MovedGlb(*document).encoded(options);
  EXPECT_EQ(encoded.position_bits, 16);
  EXPECT_EQ(encoded.draco_method, DracoMethod::Edgebreaker);
  EXPECT_NE(decoded_glb(encoded.bytes), nullptr);
}

TEST(GlbDraco, MorphTargetsKeepTheOrderOfThePoints) {
  CompressedFile file({.method = DracoMethod::Edgebreaker, .position_bits = 12});
  const std::size_t points = file.glb.json["accessors"][0]["count"].get<std::size_t>();
  const int target = file.glb.vectors(std::vector<Vec3f>(points));
  file.glb.json["meshes"][0]["primitives"][0]["targets"] = Json::array({{{"POSITION", target}}});
  const std::string bytes = file.glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const MovedGlb moved = MovedGlb(*document).shake(0.005f);
  const Encoded encoded = moved.encoded();
  EXPECT_EQ(encoded.draco_method, DracoMethod::Sequential);
  EXPECT_EQ(find_warning(encoded, "order_not_kept"), nullptr);
  const auto again = decoded_glb(encoded.bytes);
  ASSERT_NE(again, nullptr);
  ASSERT_EQ(again->positions().size(), points);
  for (Index v = 0; v < points; ++v) EXPECT_LT(length(again->positions()[v] - moved.view().at(v)), 1e-3);
}

TEST(GlbDraco, SharesItsAttributesWithOtherFormats) {
  const std::string bytes = CompressedFile({}).glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const auto shared = document->shared_attributes(MovedGlb(*document).view(), {});
  ASSERT_TRUE(shared.ok());
  ASSERT_TRUE(shared->normals && shared->texture_coordinates);
  const auto mesh = seamed_sphere();
  const auto t = document->triangles()[5];
  std::array<std::uint8_t, 3> color{};
  mesh->GetNamedAttribute(DracoAttribute::COLOR)
      ->GetMappedValue(mesh->face(draco::FaceIndex(5))[0], color.data());
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(shared->colors[3 * t[0] + c], color[c] / 255.0, 1e-6);
  std::array<float, 2> uv{};
  mesh->GetNamedAttribute(DracoAttribute::TEX_COORD)
      ->GetMappedValue(mesh->face(draco::FaceIndex(5))[0], uv.data());
  const float* const row =
      &shared->texture_coordinates->values[2 * shared->texture_coordinates->corners[5][0]];
  EXPECT_EQ(row[0], uv[0]);
  EXPECT_EQ(row[1], 1 - uv[1]);
}

TEST(GlbDraco, RefusesWhatItCannotKeepAlike) {
  const auto refusal = [](auto change) {
    CompressedFile file({.position_bits = 11});
    change(file.glb.json, file.view);
    return glb_error(file.glb.bytes());
  };
  const Error twice = refusal([](Json& json, int) { json["accessors"][0]["bufferView"] = 0; });
  EXPECT_EQ(twice.cause, Cause::UnsupportedFormat);
  EXPECT_NE(twice.message.find("mesh 0, primitive 0 holds its POSITION twice"), std::string::npos)
      << twice.message;
  const Error id = refusal([](Json& json, int) {
    json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] =
        99;
  });
  EXPECT_EQ(id.cause, Cause::MalformedMesh);
  const Error cut = refusal([](Json& json, int view) {
    auto& length = json["bufferViews"][static_cast<std::size_t>(view)]["byteLength"];
    length = length.get<int>() - 9;
  });
  EXPECT_EQ(cut.cause, Cause::MalformedMesh);
  EXPECT_TRUE(cut.message.starts_with("mesh 0, primitive 0: ")) << cut.message;
}

TEST(GlbDraco, AViewThatHoldsCompressedBytesAndOthersCannotGrow) {
  CompressedFile file({.position_bits = 11});
  file.glb.json["bufferViews"].push_back({{"buffer", 0}, {"byteLength", file.glb.bin.size()}});
  const std::string bytes = file.glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const MovedGlb moved = MovedGlb(*document).shake();
  const auto encoded = encode(*document, moved.view(), {}, {});
  ASSERT_FALSE(encoded.ok());
  EXPECT_EQ(encoded.error().cause, Cause::CannotEncode);
  EXPECT_EQ(encoded.error().message.substr(0, 45), "bufferViews[3] shares bytes with bufferViews[");
}

}  // namespace
}  // namespace burnish::testing
