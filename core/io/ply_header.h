// Private to the PLY codec: what a header declares.
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/codec.h"

namespace burnish {

enum class PlyEncoding : std::uint8_t { Text, LittleEndian, BigEndian };

enum class PlyType : std::uint8_t { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };
std::uint64_t size_of(PlyType type);
std::string_view name_of(PlyType type);  ///< "float"
inline bool is_real(PlyType type) { return type >= PlyType::Float32; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::Float32;         ///< of a list: of its items
  std::optional<PlyType> count_type = {};  ///< of a list
  std::uint64_t offset = 0;                ///< in a binary row, while no list comes before
  bool is_list() const { return count_type.has_value(); }
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  std::uint64_t line = 0;         ///< of its declaration
  std::uint64_t least_bytes = 0;  ///< of a row: binary, or of text one byte and a blank for each word
  bool has_list = false;          ///< else every binary row has least_bytes

  const PlyProperty* find(std::string_view name) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Text;
  std::vector<PlyElement> elements;
  std::uint64_t end = 0;  ///< where the data begin
  bool has_comments = false;

  /// The index of an element; elements.size() when there is none of the name.
  std::size_t find(std::string_view name) const;
};

/// Reads the header alone: whether the file holds what it declares is not its concern. Errors: MalformedMesh,
/// UnsupportedFormat, TooLarge (max-attributes, max-line-bytes); each names the line.
Result<PlyHeader> read_ply_header(std::string_view bytes, const Limits& limits);

/// The elements that are the mesh; elements.size(): there is none.
struct PlyLayout {
  std::size_t vertices = 0, faces = 0;
  std::array<const PlyProperty*, 3> axes{};  ///< x, y, z: float or double
};
/// Errors: EmptyMesh, NotATriangleMesh, MalformedMesh, UnsupportedFormat, TooLarge.
Result<PlyLayout> find_ply_layout(const PlyHeader& header, const Limits& limits);

/// The list that holds the vertices of faces or strips, under either of its names; nothing: there is none.
const PlyProperty* ply_vertex_indices(const PlyElement& element);

/// `the mesh has more than 5 vertices (max-vertices) (line 3)`
Error ply_too_large(const PlyElement& element, const std::string& what, std::uint64_t limit,
                    const std::string& name);

/// A number of a binary file.
template <class Number>
Number load_number(const char* at, PlyEncoding encoding) {
  static_assert(std::endian::native == std::endian::little);
  char bytes[sizeof(Number)];
  std::memcpy(bytes, at, sizeof bytes);
  if (encoding == PlyEncoding::BigEndian) {
    for (std::size_t i = 0; i < sizeof bytes / 2; ++i) std::swap(bytes[i], bytes[sizeof bytes - 1 - i]);
  }
  return std::bit_cast<Number>(bytes);
}

template <class Number>
void store_number(char* at, PlyEncoding encoding, Number value) {
  std::memcpy(at, &value, sizeof value);
  if (encoding != PlyEncoding::BigEndian) return;
  for (std::size_t i = 0; i < sizeof value / 2; ++i) std::swap(at[i], at[sizeof value - 1 - i]);
}

/// The same, of any type.
double load_real(const char* at, PlyType type, PlyEncoding encoding);
std::int64_t load_integer(const char* at, PlyType type, PlyEncoding encoding);

}  // namespace burnish
