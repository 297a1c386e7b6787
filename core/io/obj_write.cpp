#include <algorithm>

#include "core/io/obj_document.h"
#include "core/io/text_number.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr int kUnitDecimals = 6;  // of normals and colours

/// Copies a text, replacing stretches of it in ascending order.
class Patcher {
 public:
  explicit Patcher(std::string_view text) : text_(text) { out_.reserve(text.size() + text.size() / 8 + 64); }

  /// Where the replacement for `range` is to be appended.
  std::string& replace(const TextRange& range) {
    out_.append(text_, copied_, range.begin - copied_);
    copied_ = range.begin + range.length;
    return out_;
  }

  std::string finish() && {
    out_.append(text_, copied_);
    return std::move(out_);
  }

 private:
  std::string_view text_;
  std::string out_;
  std::uint64_t copied_ = 0;
};

/// Visits vertices and normals in the order of the file. False when stopped.
template <class Vertex, class Normal>
bool in_file_order(std::span<const TextRange> vertices, std::span<const TextRange> normals,
                   const RunControl& run, Vertex&& vertex, Normal&& normal) {
  for (std::size_t v = 0, n = 0; v < vertices.size() || n < normals.size();) {
    if ((v + n) % kBlockSize == 0 && run.stopped()) return false;
    const bool take_vertex =
        n == normals.size() || (v < vertices.size() && vertices[v].begin < normals[n].begin);
    if (take_vertex) {
      vertex(v++);
    } else {
      normal(n++);
    }
  }
  return true;
}

void append_integer(std::string& out, Index value) {
  char buffer[12];
  char* at = buffer + sizeof buffer;
  do {
    *--at = static_cast<char>('0' + value % 10);
    value /= 10;
  } while (value > 0);
  out.append(at, buffer + sizeof buffer);
}

void append_rows(std::string& out, const char* keyword, const MeshAttribute& attribute,
                 const DecimalWriter& writer) {
  const std::size_t width = static_cast<std::size_t>(attribute.components);
  for (std::size_t row = 0; row * width < attribute.values.size(); ++row) {
    out += keyword;
    for (std::size_t c = 0; c < width; ++c) {
      out += ' ';
      writer.append(out, attribute.values[row * width + c]);
    }
    out += '\n';
  }
}

void append_corner(std::string& out, Index vertex, Index texture, Index normal) {
  out += ' ';
  append_integer(out, vertex + 1);
  if (texture == kNone && normal == kNone) return;
  out += '/';
  if (texture != kNone) append_integer(out, texture + 1);
  if (normal == kNone) return;
  out += '/';
  append_integer(out, normal + 1);
}

}  // namespace

Result<Encoded> ObjDocument::encode_same(const MovedPositions& moved, const OutputOptions&,
                                         const RunControl& run) const {
  CornerNormals normals;
  if (!corner_normals_.empty()) {
    auto fresh = corner_normals(moved, triangles_, corner_normals_, normal_text_.size(), run);
    if (!fresh) return fresh.error();
    normals = std::move(*fresh);
  }
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  Encoded encoded;
  Patcher patcher(text_);
  const bool done = in_file_order(
      vertex_text_, normals.normals.empty() ? std::span<const TextRange>{} : normal_text_, run,
      [&](std::size_t v) {
        const Index vertex = static_cast<Index>(v);
        if (!moved.moved(vertex)) return;
        coordinates.append(patcher.replace(vertex_text_[v]), moved.at(vertex));
        encoded.quantisation_error = coordinates.largest_error();
      },
      [&](std::size_t n) {
        const Vec3f& normal = normals.normals[n];
        // A bare "vn" has no place for numbers: they would become a part of the keyword.
        if (normals.touched[n] && normal_text_[n].length > 0 && !(normal == Vec3f{}))
          units.append(patcher.replace(normal_text_[n]), to_double(normal));
      });
  if (!done) return run.stop_error();
  encoded.bytes = std::move(patcher).finish();
  return encoded;
}

Result<Encoded> encode_as_obj(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run) {
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  Encoded encoded;
  std::string& out = encoded.bytes;
  for (std::size_t v = 0; v < moved.original.size(); ++v) {
    if (v % kBlockSize == 0 && run.stopped()) return run.stop_error();
    out += "v ";
    coordinates.append(out, moved.at(static_cast<Index>(v)));
    for (std::size_t c = 3 * v; c < 3 * v + 3 && !attributes.colors.empty(); ++c) {
      out += ' ';
      units.append(out, attributes.colors[c]);
    }
    out += '\n';
  }
  const auto &textures = attributes.texture_coordinates, &normals = attributes.normals;
  if (textures) append_rows(out, "vt", *textures, DecimalWriter(8));
  if (normals) append_rows(out, "vn", *normals, units);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (t % kBlockSize == 0 && run.stopped()) return run.stop_error();
    out += 'f';
    for (std::size_t c = 0; c < 3; ++c) {
      append_corner(out, triangles[t][c], textures ? textures->corners[t][c] : kNone,
                    normals ? normals->corners[t][c] : kNone);
    }
    out += '\n';
  }
  encoded.quantisation_error = coordinates.largest_error();
  return encoded;
}

}  // namespace burnish
