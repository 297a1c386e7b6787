// GLB in and out: everything but moved positions, their normals and their bounds comes back byte for byte.
#include <algorithm>

#include "tests/core/glb_fixture.h"

namespace burnish::testing {
namespace {

/// A textured sphere in JSON that no writer would write, with all that a codec could lose: materials, a
/// picture, an animation, extras, extensions that nobody knows, members in an odd order, a chunk behind.
struct OddFile {
  static constexpr std::size_t kPicture = 16;
  Shape shape = sphere(2);
  std::size_t vertices = shape.positions.size();
  std::size_t position_at = kPicture, normal_at = position_at + 12 * vertices,
              texture_at = normal_at + 12 * vertices, index_at = texture_at + 8 * vertices;
  std::string bin, json, rest;

  OddFile() {
    bin = std::string("\x89PNG, they say..", kPicture);
    bin += bytes_of(float_positions(shape)) + bytes_of(directions(shape));
    bin += std::string(8 * vertices, '\x3f');
    bin += bytes_of(indices_of<std::uint16_t>(shape));
    const auto number = [](std::size_t n) { return std::to_string(n); };
    const std::string views =
        "\"bufferViews\" :[\n{ \"buffer\":0,\"byteLength\":16},"
        "{\"byteLength\": " +
        number(12 * vertices) +
        ", \"byteOffset\":16, \"buffer\":0 , \"name\" : \"p\\u006f\\\"s\"},"
        "{\"buffer\":0,\"byteOffset\":" +
        number(normal_at) + ",\"byteLength\":" + number(12 * vertices) +
        "},"
        "{\"buffer\":0,\"byteOffset\":" +
        number(texture_at) + ",\"byteLength\":" + number(8 * vertices) +
        "},"
        "{\"buffer\":0,\"byteOffset\":" +
        number(index_at) + ",\"byteLength\":" + number(6 * shape.triangles.size()) + "}]";
    const std::string accessors =
        " \"\\u0061ccessors\":[ {\"min\" : [ -1.0,\t-1e0 , -1 "
        "],\"extras\":{\"min\":[7,7,7]},\"bufferView\":1,\"componentType\":5126,\"count\":" +
        number(vertices) +
        ",\"type\":\"VEC3\",\"max\":[1,1,1.00]},"
        "{\"bufferView\":2,\"componentType\":5126,\"count\":" +
        number(vertices) +
        ",\"type\":\"VEC3\"},"
        "{\"bufferView\":3,\"componentType\":5126,\"count\":" +
        number(vertices) +
        ",\"type\":\"VEC2\"},"
        "{\"bufferView\":4,\"componentType\":5123,\"count\":" +
        number(3 * shape.triangles.size()) +
        ",\"type\":\"SCALAR\"},"
        "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"SCALAR\",\"min\":[0],\"max\":[3]}]";
    json =
        "{ \"zebra\": [[[{}]]], \"asset\":{\"generator\":\"by hand "
        "\\ud83d\\ude00\",\"version\":\"2.0\"},\r\n" +
        views + "," + accessors +
        ",\"extensionsUsed\":[\"KHR_materials_unlit\",\"ACME_unheard_of\"],"
        "\"extensions\":{\"ACME_unheard_of\":{\"deep\":[1.50,2e-3,{\"a\":null}]}},"
        "\"images\":[{\"bufferView\":0,\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],"
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},\"extensions\":{\"KHR_"
        "materials_unlit\":{}}}],"
        "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],"
        "\"samplers\":[{\"input\":4,\"output\":1}]}],"
        "\"meshes\":[{\"extras\":{\"scanner\":3},\"name\":\"ball\",\"primitives\":[{\"material\":0,"
        "\"indices\":3,"
        "\"attributes\":{\"TEXCOORD_0\":2,\"NORMAL\":1,\"POSITION\":0}}]}],"
        "\"nodes\":[{\"mesh\":0,\"name\":\"globe\",\"scale\":[2,2,2]}],\"scenes\":[{\"nodes\":[0]}],"
        "\"scene\":0,"
        "\"buffers\":[{\"byteLength\":" +
        number(bin.size()) + "}] }   ";
    rest = std::string("\4\0\0\0OWN data", 12);
  }

  std::string bytes() const { return to_glb(json, bin, rest); }
};

TEST(Glb, MovesPositionsNormalsAndBoundsAndNothingElse) {
  const OddFile file;
  const std::string bytes = file.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  ASSERT_EQ(document->positions().size(), file.vertices);
  ASSERT_EQ(document->triangles().size(), file.shape.triangles.size());
  MovedGlb moved(*document);
  moved.shake(0.01f, [](const Vec3d& p) { return p.z < -0.5; });
  const Encoded encoded = moved.encoded();
  const GlbChunks before = split_glb(bytes), after = split_glb(encoded.bytes);

  // The JSON but for the numbers of one accessor's bounds, and the blanks that fill the chunk up.
  const auto without = [](std::string json) {
    for (const std::string_view key : {R"("min" : [)", R"(,"max":[)"}) {
      for (std::size_t at = json.find(key); at != std::string::npos; at = json.find(key, at)) {
        at += key.size();
        json.replace(at, json.find(']', at) - at, "BOUNDS");
      }
    }
    return json.substr(0, json.find_last_not_of(' ') + 1);
  };
  EXPECT_EQ(without(after.json), without(before.json));
  EXPECT_EQ(without(after.json).find("BOUNDS") != std::string::npos, true);
  EXPECT_NE(after.json, before.json);
  EXPECT_EQ(after.rest, before.rest);
  ASSERT_EQ(after.bin.size(), before.bin.size());

  Vec3f low{9, 9, 9}, high{-9, -9, -9};
  std::size_t moved_rows = 0, turned = 0;
  for (Index v = 0; v < file.vertices; ++v) {
    const std::size_t at = file.position_at + 12 * v;
    const bool same = after.bin.substr(at, 12) == before.bin.substr(at, 12);
    EXPECT_EQ(same, !moved.view().moved(v)) << v;
    moved_rows += !same;
    const auto p = value_at<Vec3f>(after.bin, at);
    EXPECT_EQ(p, moved.wanted(v));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    }
    const auto n = value_at<Vec3f>(after.bin, file.normal_at + 12 * v);
    turned += !(n == value_at<Vec3f>(before.bin, file.normal_at + 12 * v));
    EXPECT_NEAR(length(n), 1, 1e-5);
    EXPECT_GT(dot(n, p), 0.95f);
  }
  EXPECT_GT(moved_rows, file.vertices / 2);
  EXPECT_GE(turned, moved_rows);
  EXPECT_LT(turned, file.vertices);
  EXPECT_EQ(after.bin.substr(0, file.position_at), before.bin.substr(0, file.position_at));
  EXPECT_EQ(after.bin.substr(file.texture_at), before.bin.substr(file.texture_at));

  const auto json = nlohmann::json::parse(after.json);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(json["accessors"][0]["min"][axis].get<float>(), low[axis]);
    EXPECT_EQ(json["accessors"][0]["max"][axis].get<double>(), double{high[axis]});
  }
  EXPECT_LT(encoded.quantisation_error, 1e-7);
  EXPECT_EQ(encoded.format, Format::Glb);
}

TEST(Glb, WhatDoesNotMoveIsTheSameFile) {
  const OddFile file;
  const std::string bytes = file.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(MovedGlb(*document).encoded().bytes, bytes);
  EXPECT_TRUE(MovedGlb(*document).encoded().warnings.empty());
}

TEST(Glb, IsKnownByItsContent) {
  EXPECT_EQ(detect_format(OddFile().bytes()), Format::Glb);
  EXPECT_EQ(format_name(Format::Glb), "glb");
}

TEST(Glb, NamesPlacesInTheFilesOwnTerms) {
  TestGlb glb;
  glb.mesh(sphere(0), "first");
  glb.mesh(sphere(0));
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(document->vertex_place(3), "vertex 3 of mesh 0 \"first\", primitive 0");
  EXPECT_EQ(document->vertex_place(12), "vertex 0 of mesh 1, primitive 0");
  EXPECT_EQ(document->triangle_place(19), "triangle 19 of mesh 0 \"first\", primitive 0");
  EXPECT_EQ(document->triangle_place(20), "triangle 0 of mesh 1, primitive 0");
}

TEST(Glb, EqualPositionsMoveAsOneWithinAMeshOnly) {
  TestGlb glb;
  const Shape shape = sphere(1);
  const int first = glb.positions(float_positions(shape)), second = glb.positions(float_positions(shape)),
            third = glb.positions(float_positions(shape)),
            index = glb.indices(indices_of<std::uint16_t>(shape));
  const auto primitive = [&](int position) {
    return nlohmann::ordered_json{{"attributes", {{"POSITION", position}}}, {"indices", index}};
  };
  glb.mesh({primitive(first), primitive(second)});
  glb.mesh(nlohmann::ordered_json::array({primitive(third)}));
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const MovedGlb moved(*document);
  const std::size_t n = shape.positions.size();
  EXPECT_EQ(moved.surface.mesh.positions.size(), 2 * n);
  for (std::size_t v = 0; v < n; ++v) {
    EXPECT_EQ(moved.surface.weld[v], moved.surface.weld[n + v]);
    EXPECT_NE(moved.surface.weld[v], moved.surface.weld[2 * n + v]);
  }
}

TEST(Glb, ATextureSeamStaysSmoothAcrossPrimitives) {
  // Two halves of a sphere, whose rim both have for their own.
  const Shape whole = sphere(3);
  Shape halves[2] = {whole, whole};
  for (std::size_t h = 0; h < 2; ++h) {
    std::erase_if(halves[h].triangles, [&](const Triangle& t) {
      const Vec3d middle = whole.positions[t[0]] + whole.positions[t[1]] + whole.positions[t[2]];
      return (middle.z > 0) == (h == 0);
    });
  }
  TestGlb glb;
  nlohmann::ordered_json primitives;
  for (const Shape& half : halves) {
    primitives.push_back(
        {{"attributes",
          {{"POSITION", glb.positions(float_positions(half))}, {"NORMAL", glb.vectors(directions(half))}}},
         {"indices", glb.indices(indices_of<std::uint32_t>(half))}});
  }
  glb.mesh(primitives);
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const GlbChunks after = split_glb(MovedGlb(*document).shake().encoded().bytes);
  const auto views = nlohmann::json::parse(after.json)["bufferViews"];
  std::size_t on_both = 0;
  for (std::size_t v = 0; v < whole.positions.size(); ++v) {
    const auto uses = [&](const Shape& half) {
      return std::ranges::any_of(half.triangles,
                                 [&](const Triangle& t) { return std::ranges::find(t, v) != t.end(); });
    };
    if (!uses(halves[0]) || !uses(halves[1])) continue;
    ++on_both;
    const auto row = [&](std::size_t view) {
      return value_at<Vec3f>(after.bin, views[view]["byteOffset"].get<std::size_t>() + 12 * v);
    };
    EXPECT_EQ(row(0), row(3));
    EXPECT_EQ(row(1), row(4));
  }
  EXPECT_GT(on_both, 10U);
}

TEST(Glb, SaysWhatItLeavesAsItIs) {
  TestGlb glb;
  const Shape shape = sphere(1);
  const int position = glb.positions(float_positions(shape)), target = glb.vectors(directions(shape));
  const int tangent = glb.accessor(glb.view(std::string(16 * shape.positions.size(), '\0')), 0,
                                   shape.positions.size(), kGlbFloat, "VEC4");
  const int index = glb.indices(indices_of<std::uint16_t>(shape));
  glb.mesh({{{"attributes", {{"POSITION", position}, {"TANGENT", tangent}}},
             {"indices", index},
             {"targets", {{{"POSITION", target}}}}},
            {{"attributes", {{"POSITION", position}}}, {"mode", 0}},
            {{"attributes", {{"POSITION", position}}}, {"mode", 3}}},
           "face");
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  EXPECT_EQ(document->triangles().size(), shape.triangles.size());
  const Encoded encoded = MovedGlb(*document).shake().encoded();
  for (const auto& [code, count, place] :
       {std::tuple{"primitives_not_smoothed", 2U, "mesh 0 \"face\", primitive 1"},
        std::tuple{"tangents_kept", 1U, "mesh 0 \"face\", primitive 0"},
        std::tuple{"morph_targets_kept", 1U, "primitive 0"}}) {
    const Warning* const warning = find_warning(encoded, code);
    ASSERT_NE(warning, nullptr) << code;
    EXPECT_EQ(warning->count, count);
    EXPECT_NE(warning->message.find(place), std::string::npos) << warning->message;
  }
}

TEST(Glb, PinsByMeshOrNode) {
  TestGlb glb;
  glb.mesh(sphere(0), "left");
  glb.mesh(sphere(0));
  glb.json["nodes"] = {{{"name", "lamp"}, {"mesh", 1}}, {{"name", "empty"}}};
  const std::string bytes = glb.bytes();
  const auto document = decoded_glb(bytes);
  ASSERT_NE(document, nullptr);
  const auto first = document->group_vertices("left", {}), second = document->group_vertices("lamp", {}),
             number = document->group_vertices("1", {}), none = document->group_vertices("right", {});
  ASSERT_TRUE(first.ok() && second.ok() && number.ok());
  EXPECT_EQ(first->size(), 12U);
  EXPECT_EQ(first->front(), 0U);
  EXPECT_EQ(second->front(), 12U);
  EXPECT_EQ(number.value(), second.value());
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().message, "the mesh has no group \"right\"; it has \"left\", \"1\", \"lamp\"");
}

}  // namespace
}  // namespace burnish::testing
