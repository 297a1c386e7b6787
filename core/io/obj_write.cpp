#include <algorithm>
#include <atomic>

#include "core/io/obj_document.h"
#include "core/io/text_number.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr int kUnitDecimals = 6;  // of normals and colours

/// A place between lines of vertices and normals: the next of each.
struct Place {
  std::uint64_t offset = 0;
  std::size_t vertex = 0, normal = 0;
};

/// The first vertex or normal at or behind `offset`, or the one that `offset` is in.
std::size_t next_range(std::span<const TextRange> ranges, std::uint64_t offset) {
  const auto next = std::ranges::lower_bound(ranges, offset, {}, &TextRange::begin);
  const auto index = static_cast<std::size_t>(next - ranges.begin());
  const bool inside = index > 0 && ranges[index - 1].begin + ranges[index - 1].length > offset;
  return inside ? index - 1 : index;
}

Place place_at(std::uint64_t offset, std::span<const TextRange> vertices,
               std::span<const TextRange> normals) {
  Place place{offset, next_range(vertices, offset), next_range(normals, offset)};
  if (place.vertex < vertices.size()) place.offset = std::min(place.offset, vertices[place.vertex].begin);
  if (place.normal < normals.size()) place.offset = std::min(place.offset, normals[place.normal].begin);
  return place;
}

/// Visits vertices and normals between two places in the order of the file. False when stopped.
template <class Vertex, class Normal>
bool in_file_order(std::span<const TextRange> vertices, std::span<const TextRange> normals, const Place& from,
                   const Place& to, const RunControl& run, Vertex&& vertex, Normal&& normal) {
  for (std::size_t v = from.vertex, n = from.normal; v < to.vertex || n < to.normal;) {
    if ((v + n) % kBlockSize == 0 && run.stopped()) return false;
    const bool take_vertex = n == to.normal || (v < to.vertex && vertices[v].begin < normals[n].begin);
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

/// Cut short when stopped.
std::string joined(std::vector<std::string> parts, const RunControl& run) {
  std::string all = std::move(parts.front());
  std::size_t size = 0;
  for (const std::string& part : parts) size += part.size();
  all.reserve(all.size() + size);
  for (std::size_t i = 1; i < parts.size() && !run.stopped(); ++i) {
    all += parts[i];
    parts[i] = {};
  }
  return all;
}

}  // namespace

Result<Encoded> ObjDocument::encode_same(const MovedPositions& moved, const OutputOptions& options,
                                         const RunControl& run) const {
  CornerNormals normals;
  if (!corner_normals_.empty()) {
    auto fresh = corner_normals(moved, triangles_, corner_normals_, normal_text_.size(), run);
    if (!fresh) return fresh.error();
    normals = std::move(*fresh);
  }
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  const std::span<const TextRange> normal_text =
      normals.normals.empty() ? std::span<const TextRange>{} : normal_text_;
  // Parts between places spread over the text, each written for itself.
  const std::size_t parts =
      thread_count(run) == 1 ? 1 : static_cast<std::size_t>(text_.size() / options.part_bytes) + 1;
  std::vector<Place> places;
  for (std::size_t i = 0; i < parts; ++i)
    places.push_back(place_at(text_.size() / parts * i, vertex_text_, normal_text));
  places.push_back({text_.size(), vertex_text_.size(), normal_text.size()});
  std::vector<std::string> written(parts);
  std::atomic<bool> any_moved = false;
  const bool done = parallel_tasks(parts, run, [&](std::size_t part) {
    const Place &from = places[part], &to = places[part + 1];
    Patcher patcher(text_, from.offset, to.offset);
    bool moved_here = false;
    in_file_order(
        vertex_text_, normal_text, from, to, run,
        [&](std::size_t v) {
          const Index vertex = static_cast<Index>(v);
          if (!moved.moved(vertex)) return;
          coordinates.append(patcher.replace(vertex_text_[v]), moved.at(vertex));
          moved_here = true;
        },
        [&](std::size_t n) {
          const Vec3f& normal = normals.normals[n];
          // A bare "vn" has no place for numbers: they would become a part of the keyword.
          if (normals.touched[n] && normal_text_[n].length > 0 && !(normal == Vec3f{}))
            units.append(patcher.replace(normal_text_[n]), to_double(normal));
        });
    written[part] = std::move(patcher).finish();
    if (moved_here) any_moved = true;
  });
  if (!done) return run.stop_error();
  Encoded encoded;
  if (any_moved) encoded.quantisation_error = coordinates.largest_error();
  encoded.bytes = joined(std::move(written), run);
  if (run.stopped()) return run.stop_error();
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
