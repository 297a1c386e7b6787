#include <algorithm>
#include <cmath>
#include <limits>

#include "core/io/colors.h"
#include "core/io/ply_document.h"
#include "core/io/ply_source.h"
#include "core/io/seams.h"
#include "core/io/text_number.h"

namespace burnish {
namespace {

using Name = std::string_view;
constexpr int kUnitDecimals = 6;  // of normals

/// The nearest float; never infinite.
float nearest_float(double value) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kMost, kMost));
}

/// Stores a number as float or double; returns how far it is from what was to be stored.
double store_real(char* at, PlyType type, PlyEncoding encoding, double value) {
  if (type == PlyType::Float64) {
    store_number(at, encoding, value);
    return 0;
  }
  const float narrow = nearest_float(value);
  store_number(at, encoding, narrow);
  return std::abs(value - static_cast<double>(narrow));
}

}  // namespace

Result<Encoded> PlyDocument::encode_same(const MovedPositions& moved, const OutputOptions&,
                                         const RunControl& run) const {
  Encoded encoded;
  NormalRows normals;
  if (has_normals()) {
    auto fresh = recompute_normals(moved, run);
    if (!fresh) return fresh.error();
    normals = std::move(*fresh);
  } else if (vertices().find("nx") != nullptr) {
    encoded.warnings.push_back({"normals_not_recomputed",
                                "the vertices have normals in a form that is not recomputed; they are those "
                                "of the input",
                                1});
  }
  if (face_element_ < header_.elements.size() && header_.elements[face_element_].find("nx") != nullptr)
    encoded.warnings.push_back(
        {"normals_not_recomputed", "the faces have normals of their own; they are those of the input", 1});
  if (header_.encoding == PlyEncoding::Text) {
    bool any_moved = false;
    auto text = patch_text(moved, normals, any_moved, run);
    if (!text) return text.error();
    encoded.bytes = std::move(*text);
    if (any_moved) encoded.quantisation_error = DecimalWriter(moved.frame).largest_error();
  } else {
    encoded.bytes = bytes_;
    if (auto ok = patch_binary(moved, normals, encoded.bytes, encoded.quantisation_error, run); !ok)
      return ok.error();
  }
  return encoded;
}

Result<> PlyDocument::patch_binary(const MovedPositions& moved, const NormalRows& normals, std::string& out,
                                   double& error, const RunControl& run) const {
  const PlyElement& element = vertices();
  const std::array<Name, 6> names{"x", "y", "z", "nx", "ny", "nz"};
  std::array<const PlyProperty*, 6> properties{};
  for (std::size_t i = 0; i < names.size(); ++i) properties[i] = element.find(names[i]);
  const bool done = for_each(positions_.size(), run.on_one_thread(), [&](std::size_t v) {
    const bool shifted = moved.moved(static_cast<Index>(v));
    const bool turned = !normals.rows.empty() && normals.changed[normals.row_of_element[v]] != 0;
    if (!shifted && !turned) return;
    const std::uint64_t row = vertex_row(static_cast<Index>(v));
    std::array<std::uint64_t, 6> offsets{};
    if (element.has_list) {
      PlyBinarySource source(bytes_, row, header_.encoding);
      std::int64_t count = 0;
      read_ply_row(source, element, count, [&](const PlyProperty& property, std::uint64_t n) {
        for (std::size_t i = 0; i < properties.size(); ++i) {
          if (&property == properties[i]) offsets[i] = source.offset();
        }
        return source.skip(property.type, n);
      });
    } else {
      for (std::size_t i = 0; i < properties.size(); ++i) {
        if (properties[i] != nullptr) offsets[i] = row + properties[i]->offset;
      }
    }
    const auto store = [&](std::size_t i, double value) {
      return store_real(&out[offsets[i]], properties[i]->type, header_.encoding, value);
    };
    if (shifted) {
      const Vec3d to = moved.at(static_cast<Index>(v));
      error = std::max(error, length(Vec3d{store(0, to.x), store(1, to.y), store(2, to.z)}));
    }
    if (turned) {
      const Vec3f& n = normals.rows[normals.row_of_element[v]];
      for (std::size_t axis = 0; axis < 3; ++axis) store(3 + axis, static_cast<double>(n[axis]));
    }
  });
  return done ? Result<>{} : run.stop_error();
}

Result<std::string> PlyDocument::patch_text(const MovedPositions& moved, const NormalRows& normals,
                                            bool& any_moved, const RunControl& run) const {
  const PlyElement& element = vertices();
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  const std::array<Name, 6> names{"x", "y", "z", "nx", "ny", "nz"};
  std::array<const PlyProperty*, 6> properties{};
  for (std::size_t i = 0; i < names.size(); ++i) properties[i] = element.find(names[i]);
  Patcher patcher(bytes_, 0, bytes_.size());
  const bool done = for_each(positions_.size(), run.on_one_thread(), [&](std::size_t v) {
    const bool shifted = moved.moved(static_cast<Index>(v));
    const bool turned = !normals.rows.empty() && normals.changed[normals.row_of_element[v]] != 0;
    if (!shifted && !turned) return;
    any_moved |= shifted;
    const Vec3d to = moved.at(static_cast<Index>(v));
    const Vec3f n = turned ? normals.rows[normals.row_of_element[v]] : Vec3f{};
    PlyTextSource source(bytes_, vertex_row(static_cast<Index>(v)), header_.encoding);
    std::int64_t count = 0;
    read_ply_row(source, element, count, [&](const PlyProperty& property, std::uint64_t words) {
      const auto i = static_cast<std::size_t>(std::ranges::find(properties, &property) - properties.begin());
      if (i == properties.size() || !(i < 3 ? shifted : turned)) return source.skip(property.type, words);
      const std::uint64_t begin = source.offset();
      const std::uint64_t length = source.word().size();
      std::string& out = patcher.replace({begin, length});
      if (i < 3) {
        coordinates.append(out, to[i]);
      } else {
        units.append(out, static_cast<double>(n[i - 3]));
      }
      return true;
    });
  });
  if (!done) return run.stop_error();
  return std::move(patcher).finish();
}

namespace {

/// Writes the rows of a new file.
class PlyWriter {
 public:
  explicit PlyWriter(std::string& out) : out_(out) {}

  template <class Number>
  void put(Number value) {
    char bytes[sizeof value];
    store_number(bytes, PlyEncoding::LittleEndian, value);
    out_.append(bytes, sizeof bytes);
  }

 private:
  std::string& out_;
};

/// True when floats hold the coordinates and keep what smoothing distinguishes: the mesh is neither huge nor
/// tiny, and not much farther away than it is large.
bool floats_suffice(const MovedPositions& moved) {
  constexpr double kHuge = 1e30;
  const Vec3d& c = moved.frame.centre;
  if (moved.frame.scale() > kHuge || moved.frame.scale() < 1 / kHuge) return false;
  return std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)}) <= 4 * moved.frame.scale();
}

std::string header_of(const SeamPoints& made, const SharedAttributes& attributes, bool floats, bool bytes) {
  std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(made.points.size()) + '\n';
  const auto declare = [&](Name type, std::initializer_list<Name> names) {
    for (const Name name : names)
      header.append("property ").append(type).append(" ").append(name).append("\n");
  };
  declare(floats ? "float" : "double", {"x", "y", "z"});
  if (attributes.normals) declare("float", {"nx", "ny", "nz"});
  if (attributes.texture_coordinates) declare("float", {"s", "t"});
  if (!attributes.colors.empty()) declare(bytes ? "uchar" : "float", {"red", "green", "blue"});
  return header + "element face " + std::to_string(made.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

/// A row of an attribute; zeros where a corner has none.
void put_row(PlyWriter& writer, const MeshAttribute& attribute, Index row) {
  const auto width = static_cast<std::size_t>(attribute.components);
  for (std::size_t c = 0; c < width; ++c) writer.put(row == kNone ? 0.0f : attribute.values[row * width + c]);
}

}  // namespace

Result<Encoded> encode_as_ply(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run) {
  const auto made = split_at_seams(moved.original.size(), triangles, attributes, run);
  if (!made) return made.error();
  const bool floats = floats_suffice(moved), bytes = are_whole_bytes(attributes.colors);
  Encoded encoded;
  encoded.bytes = header_of(*made, attributes, floats, bytes);
  constexpr std::size_t kMostVertexBytes = 3 * 8 + 3 * 4 + 2 * 4 + 3 * 4, kFaceBytes = 13;
  encoded.bytes.reserve(encoded.bytes.size() + made->points.size() * kMostVertexBytes +
                        made->triangles.size() * kFaceBytes);
  PlyWriter writer(encoded.bytes);
  const RunControl one = run.on_one_thread();
  const bool done = for_each(made->points.size(), one,
                             [&](std::size_t p) {
                               const SeamPoint& point = made->points[p];
                               const Vec3d position = moved.at(point.vertex);
                               Vec3d off;
                               for (std::size_t axis = 0; axis < 3; ++axis) {
                                 if (!floats) {
                                   writer.put(position[axis]);
                                   continue;
                                 }
                                 const float narrow = nearest_float(position[axis]);
                                 off[axis] = std::abs(position[axis] - static_cast<double>(narrow));
                                 writer.put(narrow);
                               }
                               encoded.quantisation_error = std::max(encoded.quantisation_error, length(off));
                               if (attributes.normals) put_row(writer, *attributes.normals, point.normal);
                               if (attributes.texture_coordinates)
                                 put_row(writer, *attributes.texture_coordinates, point.texture);
                               for (std::size_t c = 0; c < 3 && !attributes.colors.empty(); ++c) {
                                 const float color = attributes.colors[3 * std::size_t{point.vertex} + c];
                                 if (bytes) {
                                   writer.put(whole_byte(color));
                                 } else {
                                   writer.put(color);
                                 }
                               }
                             }) &&
                    for_each(made->triangles.size(), one, [&](std::size_t t) {
                      writer.put(std::uint8_t{3});
                      for (const Index corner : made->triangles[t]) writer.put(corner);
                    });
  if (!done) return run.stop_error();
  encoded.vertices = static_cast<std::uint32_t>(made->points.size());
  return encoded;
}

}  // namespace burnish
