// PLY files of any encoding, made from rows of numbers.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "core/io/ply_header.h"
#include "tests/core/format_fixture.h"

namespace burnish::testing {

inline constexpr PlyEncoding kEncodings[] = {PlyEncoding::Text, PlyEncoding::LittleEndian,
                                             PlyEncoding::BigEndian};

inline std::string format_line(PlyEncoding encoding) {
  switch (encoding) {
    case PlyEncoding::Text:
      return "format ascii 1.0\n";
    case PlyEncoding::LittleEndian:
      return "format binary_little_endian 1.0\n";
    default:
      return "format binary_big_endian 1.0\n";
  }
}

/// Appends numbers one by one; of text, lines end where the test says so.
class PlyBody {
 public:
  explicit PlyBody(PlyEncoding encoding) : encoding_(encoding) {}

  PlyBody& put(PlyType type, double value) {
    if (encoding_ == PlyEncoding::Text) {
      char text[40];
      std::snprintf(text, sizeof text, "%s%.9g", at_begin_ ? "" : " ", value);
      at_begin_ = false;
      bytes_ += text;
      return *this;
    }
    switch (type) {
      case PlyType::Int8:
        return store(static_cast<std::int8_t>(value));
      case PlyType::Uint8:
        return store(static_cast<std::uint8_t>(value));
      case PlyType::Int16:
        return store(static_cast<std::int16_t>(value));
      case PlyType::Uint16:
        return store(static_cast<std::uint16_t>(value));
      case PlyType::Int32:
        return store(static_cast<std::int32_t>(value));
      case PlyType::Uint32:
        return store(static_cast<std::uint32_t>(value));
      case PlyType::Float32:
        return store(static_cast<float>(value));
      default:
        return store(value);
    }
  }
  PlyBody& put(PlyType type, std::initializer_list<double> values) {
    for (const double value : values) put(type, value);
    return *this;
  }
  PlyBody& end() {
    if (encoding_ == PlyEncoding::Text) bytes_ += '\n';
    at_begin_ = true;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class Number>
  PlyBody& store(Number value) {
    char bytes[sizeof value];
    store_number(bytes, encoding_, value);
    bytes_.append(bytes, sizeof bytes);
    return *this;
  }

  PlyEncoding encoding_;
  std::string bytes_;
  bool at_begin_ = true;
};

/// Five vertices with everything that scanners write, a quad, two triangles, and elements before, between and
/// behind.
inline std::string rich_ply(PlyEncoding encoding, PlyType position = PlyType::Float32) {
  const std::string p = "property " + std::string(name_of(position)) + ' ';
  std::string header =
      "ply\n" + format_line(encoding) +
      "comment made by a scanner\n"
      "obj_info num_cols 512\n"
      "element camera 1\nproperty float view_x\nproperty list uchar short spots\n"
      "element vertex 5\n" +
      p + "x\n" + p + "y\n" + p +
      "z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
      "property float quality\nproperty float s\nproperty float t\n"
      "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
      "element face 3\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
      "property ushort part\n"
      "comment the last word\nelement label 2\nproperty list uint uchar letters\nend_header\n";
  PlyBody body(encoding);
  body.put(PlyType::Float32, 1.5).put(PlyType::Uint8, 2).put(PlyType::Int16, {-7, 300}).end();
  const double xyz[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.25}, {0, 1, 0}, {0.5, 0.5, 1}};
  for (int v = 0; v < 5; ++v) {
    body.put(position, {xyz[v][0], xyz[v][1], xyz[v][2]}).put(PlyType::Float32, {0, 0, 1});
    body.put(PlyType::Uint8, {10.0 * v, 255, 51, 255})
        .put(PlyType::Float32, {0.1 * v, 0.25 * v, 1 - 0.25 * v})
        .end();
  }
  body.put(PlyType::Int32, {0, 1}).end();
  body.put(PlyType::Uint8, {1, 4}).put(PlyType::Int32, {0, 1, 2, 3}).put(PlyType::Uint16, 500).end();
  body.put(PlyType::Uint8, {2, 3}).put(PlyType::Int32, {0, 1, 4}).put(PlyType::Uint16, 501).end();
  body.put(PlyType::Uint8, {3, 3}).put(PlyType::Int32, {2, 3, 4}).put(PlyType::Uint16, 502).end();
  body.put(PlyType::Uint32, 3).put(PlyType::Uint8, {65, 66, 67}).end();
  body.put(PlyType::Uint32, 0).end();
  return header + body.bytes();
}

}  // namespace burnish::testing
