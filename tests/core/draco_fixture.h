// Draco meshes made with the library itself, and a mesh on its way through a smoothing, for the codec's
// tests.
#pragma once

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "core/io/draco.h"
#include "core/mesh/surface.h"

namespace burnish::testing {

using DracoAttribute = draco::GeometryAttribute;

inline const RunControl kRun{};
inline constexpr DracoMethod kMethods[] = {DracoMethod::Sequential, DracoMethod::Edgebreaker};

/// A document's surface with positions that a test moved.
struct Moved {
  Surface surface;
  std::vector<Vec3f> after;
  std::vector<Vec3d> original;

  explicit Moved(const Document& document) : Moved(document.positions(), document.triangles()) {}
  Moved(std::span<const Vec3d> positions, std::span<const Triangle> triangles)
      : surface(*prepare_surface(positions, triangles, kRun)),
        after(surface.mesh.positions),
        original(positions.begin(), positions.end()) {}

  MovedPositions view() const {
    return {original, surface.weld, surface.mesh.positions, after, surface.mesh.frame};
  }
};

/// A sphere with a seam of texture coordinates along one meridian (the points there come twice), bytes as
/// colours, a generic attribute, and metadata on the mesh and on the colours.
inline constexpr int kRings = 12, kSegments = 20;
inline constexpr std::uint32_t kColorId = 77, kGenericId = 31;

template <class T>
int add_point_attribute(draco::Mesh& mesh, DracoAttribute::Type type, draco::DataType data_type,
                        int components, bool normalized, const std::vector<T>& values) {
  DracoAttribute attribute;
  attribute.Init(type, nullptr, static_cast<std::uint8_t>(components), data_type, normalized,
                 static_cast<std::int64_t>(components * sizeof(T)), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()) / components);
  mesh.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(T));
  return id;
}

inline std::unique_ptr<draco::Mesh> seamed_sphere() {
  auto mesh = std::make_unique<draco::Mesh>();
  std::vector<float> positions, normals, texture;
  std::vector<std::uint8_t> colors;
  std::vector<std::int16_t> generic;
  const auto sine = [](double turn) { return static_cast<float>(std::sin(2 * 3.14159265358979 * turn)); };
  for (int ring = 1; ring < kRings; ++ring) {
    for (int segment = 0; segment <= kSegments; ++segment) {
      const double latitude = 0.5 * ring / kRings, longitude = 1.0 * (segment % kSegments) / kSegments;
      const std::array<float, 3> p = {sine(latitude) * sine(longitude + 0.25),
                                      sine(latitude) * sine(longitude), sine(latitude + 0.25)};
      positions.insert(positions.end(), p.begin(), p.end());
      normals.insert(normals.end(), p.begin(), p.end());
      texture.insert(texture.end(),
                     {static_cast<float>(segment) / kSegments, static_cast<float>(ring) / kRings});
      colors.insert(colors.end(), {static_cast<std::uint8_t>(10 * ring),
                                   static_cast<std::uint8_t>(12 * (segment % kSegments)), 255});
      generic.push_back(static_cast<std::int16_t>(ring * 100 - 700));
    }
  }
  mesh->set_num_points(static_cast<std::uint32_t>(positions.size() / 3));
  constexpr std::uint32_t kRow = kSegments + 1;
  for (std::uint32_t ring = 0; ring + 2 < kRings; ++ring) {
    for (std::uint32_t segment = 0; segment < kSegments; ++segment) {
      const draco::PointIndex a(ring * kRow + segment), b(a + 1), c(a + kRow), d(c + 1);
      mesh->AddFace({a, c, b});
      mesh->AddFace({b, c, d});
    }
  }
  add_point_attribute(*mesh, DracoAttribute::POSITION, draco::DT_FLOAT32, 3, false, positions);
  add_point_attribute(*mesh, DracoAttribute::NORMAL, draco::DT_FLOAT32, 3, false, normals);
  add_point_attribute(*mesh, DracoAttribute::TEX_COORD, draco::DT_FLOAT32, 2, false, texture);
  const int color = add_point_attribute(*mesh, DracoAttribute::COLOR, draco::DT_UINT8, 3, true, colors);
  const int other = add_point_attribute(*mesh, DracoAttribute::GENERIC, draco::DT_INT16, 1, false, generic);
  mesh->attribute(color)->set_unique_id(kColorId);
  mesh->attribute(other)->set_unique_id(kGenericId);

  auto metadata = std::make_unique<draco::GeometryMetadata>();
  metadata->AddEntryString("scanner", "bench 3");
  auto color_metadata = std::make_unique<draco::AttributeMetadata>();
  color_metadata->set_att_unique_id(kColorId);
  color_metadata->AddEntryInt("gamma", 22);
  metadata->AddAttributeMetadata(std::move(color_metadata));
  mesh->AddMetadata(std::move(metadata));
  // Edgebreaker tells seams by value, so equal positions must be one value.
  mesh->DeduplicateAttributeValues();
  return mesh;
}

/// Scales, then shifts, a mesh's positions.
inline void place(draco::Mesh& mesh, float scale, float offset) {
  draco::PointAttribute& position = *mesh.attribute(mesh.GetNamedAttributeId(DracoAttribute::POSITION));
  for (draco::AttributeValueIndex i(0); i < static_cast<std::uint32_t>(position.size()); ++i) {
    auto v = position.GetValue<float, 3>(i);
    for (float& x : v) x = x * scale + offset;
    position.SetAttributeValue(i, v.data());
  }
}

struct WriteOptions {
  DracoMethod method = DracoMethod::Sequential;
  int position_bits = 0, normal_bits = 0, texture_bits = 0;
  int speed = 5;
};

inline std::string write_with_library(const draco::Mesh& mesh, const WriteOptions& options) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(options.method == DracoMethod::Sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                                                      : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(options.speed, options.speed);
  // The entropy coder's tables grow with 2^bits: seconds and gigabytes for fine grids.
  encoder.SetUseBuiltInAttributeCompression(options.position_bits <= 20);
  const auto quantise = [&](DracoAttribute::Type type, int bits) {
    if (bits > 0) encoder.SetAttributeQuantization(mesh.GetNamedAttributeId(type), bits);
  };
  quantise(DracoAttribute::POSITION, options.position_bits);
  quantise(DracoAttribute::NORMAL, options.normal_bits);
  quantise(DracoAttribute::TEX_COORD, options.texture_bits);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  return {buffer.data(), buffer.size()};
}

inline std::unique_ptr<draco::Mesh> read_with_library(const std::string& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  EXPECT_TRUE(mesh.ok()) << mesh.status().error_msg_string();
  return mesh.ok() ? std::move(mesh).value() : nullptr;
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The three floats of a point's position or normal.
inline std::array<float, 3> at_point(const draco::Mesh& mesh, DracoAttribute::Type type,
                                     std::uint32_t point) {
  std::array<float, 3> value{};
  mesh.GetNamedAttribute(type)->GetMappedValue(draco::PointIndex(point), value.data());
  return value;
}

inline std::unique_ptr<Document> decoded(std::string_view bytes) {
  auto document = decode_draco(bytes, Limits{}, kRun);
  EXPECT_TRUE(document.ok()) << document.error().message;
  return document.ok() ? std::move(document).value() : nullptr;
}

}  // namespace burnish::testing
