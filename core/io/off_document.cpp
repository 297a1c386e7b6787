#include "core/io/off_document.h"

#include <algorithm>
#include <cmath>

#include "core/io/colors.h"
#include "core/io/text_number.h"
#include "core/io/text_scan.h"

namespace burnish {
namespace {

constexpr int kUnitDecimals = 6;  // of normals and colours

TextRange next_word(TextScanner& scanner) {
  scanner.find_word();
  const std::uint64_t begin = scanner.offset();
  return {begin, scanner.word().size()};
}

void append_whole(std::string& out, std::uint64_t value) { out.append(" ").append(std::to_string(value)); }

}  // namespace

std::string OffDocument::vertex_place(Index vertex) const {
  return "vertex " + std::to_string(vertex) + line_place(text_, vertex_begins_[vertex]);
}

std::string OffDocument::triangle_place(Index triangle) const {
  const Index face = face_of_triangle_.empty() ? triangle : face_of_triangle_[triangle];
  return "face " + std::to_string(face) + line_place(text_, face_begins_[face]);
}

Result<NormalRows> OffDocument::recompute_normals(const MovedPositions& moved, const RunControl& run) const {
  auto normals = group_normals(
      normals_.size(), moved, run, [](std::size_t v) { return static_cast<Index>(v); },
      [&](std::size_t v) { return normals_[v]; });
  if (!normals) return normals.error();
  if (auto ok = normals->recompute(moved, triangles_, triangles_, run); !ok) return ok.error();
  return normals;
}

Result<Encoded> OffDocument::encode_same(const MovedPositions& moved, const OutputOptions&,
                                         const RunControl& run) const {
  NormalRows normals;
  if (!normals_.empty()) {
    auto fresh = recompute_normals(moved, run);
    if (!fresh) return fresh.error();
    normals = std::move(*fresh);
  }
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  Patcher patcher(text_, 0, text_.size());
  Encoded encoded;
  const bool done = for_each(positions_.size(), run.on_one_thread(), [&](std::size_t v) {
    const bool shifted = moved.moved(static_cast<Index>(v));
    const bool turned = !normals.rows.empty() && normals.changed[normals.row_of_element[v]] != 0;
    if (!shifted && !turned) return;
    TextScanner scanner(text_, vertex_begins_[v], true);
    const Vec3d to = moved.at(static_cast<Index>(v));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const TextRange word = next_word(scanner);
      if (shifted) coordinates.append(patcher.replace(word), to[axis]);
    }
    for (std::size_t axis = 0; axis < 3 && turned; ++axis) {
      const Vec3f& n = normals.rows[normals.row_of_element[v]];
      units.append(patcher.replace(next_word(scanner)), static_cast<double>(n[axis]));
    }
    if (shifted) encoded.quantisation_error = coordinates.largest_error();
  });
  if (!done) return run.stop_error();
  encoded.bytes = std::move(patcher).finish();
  return encoded;
}

/// Three or four numbers behind the others of a vertex. Some programs write 0 to 255, others 0 to 1: where
/// any is above 1, all are the former.
Result<std::vector<float>> OffDocument::read_colors(const RunControl& run) const {
  std::vector<float> colors(3 * positions_.size());
  double most = 0;
  const int before = normals_.empty() ? 3 : 6;
  const bool done = for_each(positions_.size(), run.on_one_thread(), [&](std::size_t v) {
    TextScanner scanner(text_, vertex_begins_[v], true);
    for (int i = 0; i < before; ++i) next_word(scanner);
    for (std::size_t c = 0; c < 3; ++c) {
      double value = 0;
      if (!scanner.find_word_of_line() || !scanner.number(value) || !(value > 0)) value = 0;
      value = std::min(value, 255.0);
      most = std::max(most, value);
      colors[3 * v + c] = static_cast<float>(value);
    }
  });
  if (!done) return run.stop_error();
  if (most > 1) {
    for (float& color : colors) color /= 255.0f;
  }
  return colors;
}

Result<SharedAttributes> OffDocument::shared_attributes(const MovedPositions& moved,
                                                        const RunControl& run) const {
  SharedAttributes shared;
  if (!normals_.empty()) {
    const auto normals = recompute_normals(moved, run);
    if (!normals) return normals.error();
    MeshAttribute attribute{3, {}, triangles_};
    for (Triangle& corners : attribute.corners) {
      for (Index& corner : corners) corner = normals->row_of_element[corner];
    }
    for (const Vec3f& n : normals->rows) attribute.values.insert(attribute.values.end(), {n.x, n.y, n.z});
    shared.normals = std::move(attribute);
  }
  if (has_colors_) {
    auto colors = read_colors(run);
    if (!colors) return colors.error();
    shared.colors = std::move(*colors);
  }
  if (has_textures_) shared.dropped.emplace_back("texture coordinates of an STOFF");
  if (has_face_colors_) shared.dropped.emplace_back("colours of faces");
  if (!face_of_triangle_.empty()) shared.dropped.emplace_back("polygons (split into triangles)");
  if (has_comments_) shared.dropped.emplace_back("comments");
  return shared;
}

Result<Encoded> encode_as_off(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run) {
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  const std::span<const float> colors = attributes.colors;
  const bool bytes = are_whole_bytes(colors);
  Encoded encoded;
  std::string& out = encoded.bytes;
  out = colors.empty() ? "OFF\n" : "COFF\n";
  out += std::to_string(moved.original.size()) + ' ' + std::to_string(triangles.size()) + " 0\n";
  const RunControl one = run.on_one_thread();
  const bool done = for_each(moved.original.size(), one,
                             [&](std::size_t v) {
                               coordinates.append(out, moved.at(static_cast<Index>(v)));
                               for (std::size_t c = 3 * v; c < 3 * v + 3 && !colors.empty(); ++c) {
                                 if (bytes) {
                                   append_whole(out, whole_byte(colors[c]));
                                 } else {
                                   out += ' ';
                                   units.append(out, static_cast<double>(colors[c]));
                                 }
                               }
                               if (!colors.empty()) out += bytes ? " 255" : " 1";
                               out += '\n';
                             }) &&
                    for_each(triangles.size(), one, [&](std::size_t t) {
                      out += '3';
                      for (const Index corner : triangles[t]) append_whole(out, corner);
                      out += '\n';
                    });
  if (!done) return run.stop_error();
  encoded.quantisation_error = coordinates.largest_error();
  return encoded;
}

}  // namespace burnish
