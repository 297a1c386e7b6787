// Small GLB files to test with, put together by hand.
#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/shapes.h"

namespace burnish::testing {

/// A file's chunks.
struct GlbChunks {
  std::string json, bin, rest;
};

std::string to_glb(std::string_view json, std::optional<std::string_view> bin, std::string_view rest = {});
GlbChunks split_glb(std::string_view bytes);

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::vector<Vec3f> float_positions(const Shape& shape);
/// Each vertex's direction from the origin.
std::vector<Vec3f> directions(const Shape& shape);
template <class T>
std::vector<T> indices_of(const Shape& shape) {
  std::vector<T> indices;
  for (const Triangle& t : shape.triangles) indices.insert(indices.end(), t.begin(), t.end());
  return indices;
}

inline constexpr int kGlbInt8 = 5120, kGlbUInt8 = 5121, kGlbInt16 = 5122, kGlbUInt16 = 5123,
                     kGlbUInt32 = 5125, kGlbFloat = 5126;

/// Grows a file piece by piece; `json` may be changed at will between.
struct TestGlb {
  nlohmann::ordered_json json = {{"asset", {{"version", "2.0"}}}};
  std::string bin;

  int view(std::string_view bytes, int stride = 0);
  int accessor(int view, std::size_t offset, std::size_t count, int component, const char* type);
  /// With "min" and "max".
  int positions(const std::vector<Vec3f>& values);
  int vectors(const std::vector<Vec3f>& values);
  template <class T>
  int indices(const std::vector<T>& values) {
    const int component = sizeof(T) == 1 ? kGlbUInt8 : sizeof(T) == 2 ? kGlbUInt16 : kGlbUInt32;
    return accessor(view(bytes_of(values)), 0, values.size(), component, "SCALAR");
  }
  /// A mesh with these primitives; its number.
  int mesh(const nlohmann::ordered_json& primitives, const char* name = nullptr);
  /// A mesh of one primitive with positions, normals and indices of 32 bits.
  int mesh(const Shape& shape, const char* name = nullptr);

  std::string bytes() const;
};

}  // namespace burnish::testing
