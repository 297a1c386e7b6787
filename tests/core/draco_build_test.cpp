// Meshes of other formats written as Draco.
#include <set>

#include "tests/core/draco_fixture.h"

namespace burnish::testing {
namespace {

/// A square pyramid as an OBJ would give it: one vertex more than is used, and a seam of texture coordinates.
struct ObjLike {
  std::vector<Vec3d> positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {7, 7, 7}, {0.5, 0.5, 1}};
  std::vector<Triangle> triangles = {{0, 1, 5}, {1, 2, 5}, {2, 3, 5}, {3, 0, 5}, {0, 2, 1}, {0, 3, 2}};
  SharedAttributes attributes;

  ObjLike() {
    attributes.texture_coordinates = MeshAttribute{2, {0, 0, 1, 0, 0.5f, 1, 0.25f, 0.75f}, {}};
    attributes.texture_coordinates->corners = {
        {0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {0, 1, 3}, {kNone, kNone, kNone}, {0, 1, 3}};
    for (std::size_t v = 0; v < positions.size(); ++v) {
      attributes.colors.insert(attributes.colors.end(), {static_cast<float>(v) / 255, 1, 0});
    }
  }
};

TEST(DracoBuild, AnotherFormatsMeshKeepsVerticesOrderAndAttributes) {
  for (const auto method : kMethods) {
    const ObjLike obj;
    const Moved moved(obj.positions, obj.triangles);
    const auto encoded =
        encode_as_draco(moved.view(), obj.triangles, obj.attributes, {.method = method}, kRun);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    EXPECT_EQ(encoded->draco_method, method);
    EXPECT_EQ(encoded->quantisation_error, 0);
    const auto mesh = read_with_library(encoded->bytes);
    ASSERT_EQ(mesh->num_faces(), obj.triangles.size());
    const auto* texture = mesh->GetNamedAttribute(DracoAttribute::TEX_COORD);
    std::multiset<std::array<float, 5>> wanted, found;
    for (std::size_t t = 0; t < obj.triangles.size(); ++t) {
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3f p = to_float(obj.positions[obj.triangles[t][c]]);
        const Index row = obj.attributes.texture_coordinates->corners[t][c];
        const float* uv = row == kNone ? nullptr : &obj.attributes.texture_coordinates->values[2 * row];
        wanted.insert({p.x, p.y, p.z, uv ? uv[0] : 0, uv ? uv[1] : 0});
        const draco::PointIndex point = mesh->face(draco::FaceIndex(static_cast<std::uint32_t>(t)))[c];
        const auto q = at_point(*mesh, DracoAttribute::POSITION, point.value());
        std::array<float, 2> v{};
        texture->GetMappedValue(point, v.data());
        found.insert({q[0], q[1], q[2], v[0], v[1]});
      }
    }
    EXPECT_EQ(found, wanted);
    const auto* color = mesh->GetNamedAttribute(DracoAttribute::COLOR);
    EXPECT_EQ(color->data_type(), draco::DT_UINT8);
    if (method != DracoMethod::Sequential) continue;
    const auto document = decoded(encoded->bytes);
    ASSERT_GE(document->positions().size(), obj.positions.size());
    for (std::size_t v = 0; v < obj.positions.size(); ++v)
      EXPECT_EQ(document->positions()[v], obj.positions[v]);
    for (std::size_t t = 0; t < obj.triangles.size(); ++t) {
      for (std::size_t c = 0; c < 3; ++c) {
        const Index point = document->triangles()[t][c];
        EXPECT_EQ(document->positions()[point], obj.positions[obj.triangles[t][c]]);
        if (point < obj.positions.size()) {
          EXPECT_EQ(point, obj.triangles[t][c]);
        }
      }
    }
  }
}

TEST(DracoBuild, ColoursThatAreNotBytesStayFloats) {
  ObjLike obj;
  obj.attributes.colors[4] = 0.12345f;
  const Moved moved(obj.positions, obj.triangles);
  const auto encoded = encode_as_draco(moved.view(), obj.triangles, obj.attributes, {}, kRun);
  ASSERT_TRUE(encoded.ok());
  const auto mesh = read_with_library(encoded->bytes);
  EXPECT_EQ(mesh->GetNamedAttribute(DracoAttribute::COLOR)->data_type(), draco::DT_FLOAT32);
}

TEST(DracoBuild, WhatDracoCannotHoldIsRefused) {
  ObjLike obj;
  obj.positions[2].x = 1e39;
  {
    const Moved moved(obj.positions, obj.triangles);
    const auto encoded = encode_as_draco(moved.view(), obj.triangles, {}, {}, kRun);
    ASSERT_FALSE(encoded.ok());
    EXPECT_EQ(encoded.error().cause, Cause::CannotEncode);
    EXPECT_NE(encoded.error().message.find("vertex 2"), std::string::npos) << encoded.error().message;
  }
  // A decoder takes more points than corners for an attack.
  const std::vector<Vec3d> loose(20, Vec3d{1, 2, 3});
  obj = ObjLike{};
  obj.positions.insert(obj.positions.end(), loose.begin(), loose.end());
  const Moved moved(obj.positions, obj.triangles);
  const auto encoded = encode_as_draco(moved.view(), obj.triangles, {}, {}, kRun);
  ASSERT_FALSE(encoded.ok());
  EXPECT_EQ(encoded.error().cause, Cause::CannotEncode);
}

TEST(DracoBuild, DegenerateTrianglesAndLooseVerticesAreWrittenByBothMethods) {
  ObjLike obj;
  obj.triangles.insert(obj.triangles.end(), {{0, 0, 1}, {2, 2, 2}, {0, 1, 5}, {0, 1, 4}});
  const Moved moved(obj.positions, obj.triangles);
  for (const auto method : kMethods) {
    for (const int speed : {0, 5, 10}) {
      const auto encoded =
          encode_as_draco(moved.view(), obj.triangles, {}, {.method = method, .speed = speed}, kRun);
      ASSERT_TRUE(encoded.ok()) << encoded.error().message;
      const auto document = decoded(encoded->bytes);
      const bool sequential = method == DracoMethod::Sequential;
      EXPECT_EQ(document->triangles().size(), sequential ? 10u : 8u);
      EXPECT_EQ(encoded->warnings.size(), sequential ? 0u : 1u);
    }
  }
}

TEST(DracoBuild, StopEndsTheEncoding) {
  std::stop_source stop;
  stop.request_stop();
  const RunControl stopped{.stop = stop.get_token()};
  const ObjLike obj;
  const Moved other(obj.positions, obj.triangles);
  const auto fresh = encode_as_draco(other.view(), obj.triangles, obj.attributes, {}, stopped);
  ASSERT_FALSE(fresh.ok());
  EXPECT_EQ(fresh.error().cause, Cause::Cancelled);
}

}  // namespace
}  // namespace burnish::testing
