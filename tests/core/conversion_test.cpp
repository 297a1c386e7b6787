// Every format from every other.
#include <gmock/gmock.h>

#include "tests/core/ply_fixture.h"

namespace burnish::testing {
namespace {

using ::testing::HasSubstr;

constexpr Format kFormats[] = {Format::Obj, Format::Draco, Format::Ply,
                               Format::Stl, Format::Off,   Format::Glb};

/// A strip with normals, colours, and texture coordinates with a seam at its middle edge.
constexpr const char* kSeamed =
    "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 0.2 0.4 0.6\nv 2 0 0 1 1 1\nv 2 1 0 0 0 0\n"
    "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.75 0\nvt 0.75 1\nvt 1 0\nvt 1 1\n"
    "vn 0 0 1\n"
    "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\nf 2/5/1 5/7/1 6/8/1\nf 2/5/1 6/8/1 3/6/1\n";

/// The warning about what is left out; empty when there is none.
std::string dropped(const Encoded& encoded) {
  for (const Warning& warning : encoded.warnings) {
    if (warning.code == "attributes_dropped") return warning.message;
  }
  return {};
}

TEST(Conversion, KeepsPositionsAndTrianglesInTheirOrder) {
  for (const Format from : kFormats) {
    const LoadedFile source(LoadedFile(to_obj(with_noise(cube(3), 0.05))).written(from));
    for (const Format to : kFormats) {
      LoadedFile file(source.bytes);
      file.move_all();
      const LoadedFile again(file.written(to), to);
      EXPECT_EQ(again.document->positions().size(), file.document->positions().size());
      EXPECT_TRUE(std::ranges::equal(again.document->triangles(), file.document->triangles()) ||
                  to == Format::Stl);
      if (to != Format::Stl) expect_positions(*again.document, file.moved(), 2e-6);
      EXPECT_EQ(again.surface.topology.boundary_edges, 0U) << format_name(from) << " to " << format_name(to);
    }
  }
}

TEST(Conversion, ToStlKeepsTheOrderOfFacetsAndTheirPositions) {
  const LoadedFile file(to_obj(sphere(2)));
  const LoadedFile again(file.written(Format::Stl));
  ASSERT_EQ(again.document->triangles().size(), file.document->triangles().size());
  for (std::size_t t = 0; t < again.document->triangles().size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d is = again.document->positions()[again.document->triangles()[t][c]];
      const Vec3d was = file.document->positions()[file.document->triangles()[t][c]];
      ASSERT_LE(length(is - was), 1e-6);
    }
  }
}

TEST(Conversion, FromStlGivesAConnectedMesh) {
  const LoadedFile stl(LoadedFile(to_obj(sphere(2))).written(Format::Stl));
  for (const Format to : {Format::Obj, Format::Ply, Format::Off, Format::Draco}) {
    const LoadedFile again(stl.written(to));
    EXPECT_EQ(again.document->positions().size(), sphere(2).positions.size());
    EXPECT_EQ(again.surface.welded_vertices, 0U);
  }
}

TEST(Conversion, CarriesColoursNormalsAndTextureCoordinates) {
  const LoadedFile obj(kSeamed);
  for (const Format by : {Format::Ply, Format::Draco, Format::Glb}) {
    const Encoded there = obj.encoded({.format = by});
    EXPECT_EQ(dropped(there), "");
    EXPECT_EQ(there.vertices.value_or(8), 8U) << "two copies at the seam";
    const LoadedFile back(LoadedFile(there.bytes).written(Format::Obj));
    const auto was = obj.document->shared_attributes(obj.moved(), {});
    const auto is = back.document->shared_attributes(back.moved(), {});
    ASSERT_TRUE(was && is && is->normals && is->texture_coordinates);
    for (std::size_t i = 0; i < was->colors.size(); ++i) EXPECT_NEAR(is->colors[i], was->colors[i], 1e-6);
    for (std::size_t t = 0; t < 4; ++t) {
      for (std::size_t c = 0; c < 3; ++c) {
        const auto pair = [&](const SharedAttributes& of) {
          const float* const uv = &of.texture_coordinates->values[2 * of.texture_coordinates->corners[t][c]];
          return std::pair(uv[0], uv[1]);
        };
        EXPECT_EQ(pair(*is), pair(*was)) << t << ' ' << c;
        EXPECT_EQ(is->normals->values[3 * is->normals->corners[t][c] + 2], 1.0F);
      }
    }
  }
}

TEST(Conversion, CarriesColoursToOffAndBack) {
  const LoadedFile obj(kSeamed);
  const Encoded there = obj.encoded({.format = Format::Off});
  EXPECT_TRUE(there.bytes.starts_with("COFF\n6 4 0\n")) << there.bytes;
  EXPECT_THAT(there.bytes, HasSubstr(" 51 102 153 255\n"));
  EXPECT_EQ(dropped(there), "the other format cannot carry: normals; texture coordinates");
  const LoadedFile back(LoadedFile(there.bytes).written(Format::Obj));
  const auto was = obj.document->shared_attributes(obj.moved(), {}),
             is = back.document->shared_attributes(back.moved(), {});
  ASSERT_EQ(is->colors.size(), was->colors.size());
  for (std::size_t i = 0; i < was->colors.size(); ++i) EXPECT_NEAR(is->colors[i], was->colors[i], 1e-6);
}

TEST(Conversion, KeepsColoursThatAreNoWholeBytes) {
  const LoadedFile obj("v 0 0 0 0.1234 0 1\nv 1 0 0 255 128 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
  const LoadedFile ply(obj.written(Format::Ply)), off(obj.written(Format::Off));
  EXPECT_THAT(ply.bytes, HasSubstr("property float red"));
  EXPECT_THAT(off.bytes, HasSubstr(" 0.123400 0.000000 1.000000 1\n"));
  const auto shared = ply.document->shared_attributes(ply.moved(), {});
  EXPECT_EQ(shared->colors[0], 0.1234F);
  EXPECT_EQ(shared->colors[3], 1.0F) << "what is more than full is full";
}

TEST(Conversion, SaysWhatAFormatCannotHold) {
  const LoadedFile obj(kSeamed), ply(rich_ply(PlyEncoding::BigEndian));
  EXPECT_EQ(dropped(obj.encoded({.format = Format::Stl})),
            "the other format cannot carry: normals; texture coordinates; colours");
  EXPECT_EQ(dropped(ply.encoded({.format = Format::Obj})),
            "the other format cannot carry: the element \"camera\"; the property \"alpha\" of \"vertex\"; "
            "the property "
            "\"quality\" of \"vertex\"; the element \"edge\"; the property \"flags\" of \"face\"; the "
            "property \"part\" of "
            "\"face\"; the element \"label\"; polygons (split into triangles); comments");
  std::string stl = LoadedFile(to_obj(sphere(1))).written(Format::Stl);
  stl[84 + 49] = 1;
  EXPECT_EQ(dropped(LoadedFile(stl).encoded({.format = Format::Ply})),
            "the other format cannot carry: the header's text; attribute bytes of facets");
  const LoadedFile off("COFF\n3 1 0 # a\n0 0 0 1 0 0\n1 0 0 1 1 1\n0 1 0 0.5 0 0\n3 0 1 2 9\n");
  EXPECT_EQ(dropped(off.encoded({.format = Format::Ply})),
            "the other format cannot carry: colours of faces; comments");
}

TEST(Conversion, ToStlWarnsOfVerticesInNoTriangle) {
  const LoadedFile obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\n");
  const Encoded stl = obj.encoded({.format = Format::Stl});
  EXPECT_EQ(stl.vertices, 3U);
  ASSERT_EQ(stl.warnings.size(), 1U);
  EXPECT_EQ(stl.warnings[0].message, "1 vertex is in no triangle, and STL holds nothing else");
}

TEST(Conversion, ReadsTheTextureCoordinatesThatMeshLabKeepsWithFaces) {
  for (const PlyEncoding encoding : kEncodings) {
    PlyBody body(encoding);
    for (const auto& v : {std::array{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {0.0, 1.0, 0.0}})
      body.put(PlyType::Float32, {v[0], v[1], v[2]}).end();
    body.put(PlyType::Uint8, 4).put(PlyType::Int32, {0, 1, 2, 3}).put(PlyType::Uint8, 8);
    body.put(PlyType::Float32, {0, 0, 0.5, 0, 0.5, 1, 0, 1}).end();
    body.put(PlyType::Uint8, 3).put(PlyType::Int32, {0, 1, 2}).put(PlyType::Uint8, 0).end();
    const LoadedFile file(
        "ply\n" + format_line(encoding) +
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
        "end_header\n" +
        body.bytes());
    const auto shared = file.document->shared_attributes(file.moved(), {});
    ASSERT_TRUE(shared && shared->texture_coordinates);
    const MeshAttribute& textures = *shared->texture_coordinates;
    EXPECT_EQ(textures.values, (std::vector<float>{0, 0, 0.5, 0, 0.5, 1, 0, 1}));
    EXPECT_EQ(textures.corners[1], (Triangle{0, 2, 3}));
    EXPECT_EQ(textures.corners[2], (Triangle{kNone, kNone, kNone}));
  }
}

TEST(Conversion, WhatMovesPastTheLargestCoordinateStaysReadable) {
  const std::string obj = "v -1e60 0 0\nv 1e60 0 0\nv 0 1e60 0\nv 0 0 1e60\nf 1 2 3\nf 1 3 4\n";
  const std::string ply_text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "-1e60 0 0\n1e60 0 0\n0 1e60 0\n3 0 1 2\n";
  const std::string ply = LoadedFile(obj).written(Format::Ply), off = LoadedFile(obj).written(Format::Off);
  for (const std::string& bytes : {obj, ply_text, ply, off}) {
    LoadedFile file(bytes);
    file.move_all();
    ASSERT_TRUE(file.moved().moved(1));
    EXPECT_EQ(file.moved().at(1).x, kLargestCoordinate);
    for (const Format to : {Format::Obj, Format::Ply, Format::Off}) {
      const LoadedFile again(file.written(to), to);
      for (const Vec3d& p : again.document->positions())
        EXPECT_LE(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), kLargestCoordinate);
      EXPECT_EQ(again.document->positions()[1].x, kLargestCoordinate);
    }
  }
}

TEST(Conversion, SmallestMeshesMakeTheTrip) {
  for (const Format from : kFormats) {
    for (const Format to : kFormats) {
      const LoadedFile file(LoadedFile("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").written(from));
      EXPECT_EQ(LoadedFile(file.written(to)).document->triangles().size(), 1U);
    }
  }
}

}  // namespace
}  // namespace burnish::testing
