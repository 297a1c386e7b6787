#include "core/io/declared.h"

#include <algorithm>
#include <cstring>

#include "core/io/ply_header.h"
#include "core/io/stl_document.h"
#include "core/io/text_scan.h"

namespace burnish {
namespace {

constexpr std::size_t kSeenBytes = 32 << 10;
constexpr double kLeastVertexBytes = 3, kLeastTriangleBytes = 2;

/// Triangles that a polygon of a text has on the average, by its last lines: a face's begins with the count
/// of its corners.
double triangles_per_face(std::string_view text, std::uint64_t declared) {
  std::size_t begin = text.find_last_not_of("\r\n ");
  double faces = 0, triangles = 0;
  while (begin != std::string_view::npos && text.size() - begin < kSeenBytes &&
         faces < static_cast<double>(declared)) {
    begin = text.substr(0, begin).find_last_of("\r\n");
    if (begin == std::string_view::npos) break;
    TextScanner scanner(text, begin, true);
    std::int64_t corners = 0;
    if (!scanner.find_word() || !scanner.integer(corners) || corners < 3 || corners > 1000) continue;
    faces += 1;
    triangles += static_cast<double>(corners - 2);
  }
  return faces > 0 ? triangles / faces : 1;
}

/// Of binary files whose faces have one list: what the bytes behind the vertices hold beside the counts.
double triangles_of(const PlyHeader& header, const PlyElement& faces, const PlyElement& vertices,
                    std::uint64_t bytes) {
  const auto count = static_cast<double>(faces.count);
  const PlyProperty* indices = nullptr;
  for (const PlyProperty& property : faces.properties) {
    if (property.is_list()) indices = indices == nullptr ? &property : nullptr;
  }
  const bool plain = indices != nullptr && !vertices.has_list && header.elements.size() == 2;
  if (!plain) return count;
  const double behind = static_cast<double>(bytes - std::min(bytes, header.end)) -
                        static_cast<double>(vertices.count) * static_cast<double>(vertices.least_bytes) -
                        count * static_cast<double>(faces.least_bytes);
  return behind / static_cast<double>(size_of(indices->type)) - 2 * count;
}

std::optional<DeclaredCounts> of_ply(std::string_view bytes) {
  const auto header = read_ply_header(bytes.substr(0, kSeenBytes), {});
  if (!header) return {};
  const std::size_t v = header->find("vertex"), f = header->find("face"), none = header->elements.size();
  if (v == none) return {};
  const PlyElement& vertices = header->elements[v];
  DeclaredCounts counts{.vertices = static_cast<double>(vertices.count)};
  for (const std::string_view name : {"nx", "s", "u", "texture_u"})
    counts.rows += vertices.find(name) != nullptr ? counts.vertices : 0;
  if (f == none) {
    counts.triangles = 2 * counts.vertices;  // in strips
  } else if (header->encoding == PlyEncoding::Text) {
    counts.triangles =
        static_cast<double>(header->elements[f].count) * triangles_per_face(bytes, header->elements[f].count);
  } else {
    counts.triangles = triangles_of(*header, header->elements[f], vertices, bytes.size());
  }
  return counts;
}

/// A closed mesh has half as many vertices as triangles.
std::optional<DeclaredCounts> of_stl(std::string_view bytes) {
  double triangles = 0, written = 1;
  if (has_binary_stl_size(bytes)) {
    triangles = static_cast<double>(bytes.size() / kStlFacetBytes);
  } else {
    const std::string_view head = bytes.substr(0, kSeenBytes);
    TextScanner scanner(head, 0, false);
    double corners = 0;
    while (scanner.find_word()) {
      const std::string_view word = scanner.word();
      corners += word == "vertex" || word == "VERTEX";
    }
    triangles = corners / 3 * static_cast<double>(bytes.size()) /
                static_cast<double>(std::max<std::size_t>(head.size(), 1));
    written = 1.6;
  }
  return DeclaredCounts{
      .vertices = triangles / 2, .triangles = triangles, .rows = 0, .written_bytes = written};
}

std::optional<DeclaredCounts> of_off(std::string_view bytes) {
  TextScanner scanner(bytes.substr(0, kSeenBytes), 0, true);
  if (!scanner.find_word()) return {};
  const std::string_view keyword = scanner.word();
  std::int64_t vertices = 0, faces = 0;
  if (!scanner.find_word() || !scanner.integer(vertices) || !scanner.find_word() || !scanner.integer(faces))
    return {};
  DeclaredCounts counts{.vertices = static_cast<double>(vertices)};
  counts.triangles = static_cast<double>(faces) *
                     triangles_per_face(bytes, static_cast<std::uint64_t>(std::max<std::int64_t>(faces, 0)));
  if (keyword.find('N') != std::string_view::npos) counts.rows = counts.vertices;
  return counts;
}

}  // namespace

std::optional<DeclaredCounts> declared_counts(std::string_view bytes, Format format) {
  auto counts = format == Format::Ply   ? of_ply(bytes)
                : format == Format::Stl ? of_stl(bytes)
                : format == Format::Off ? of_off(bytes)
                                        : std::nullopt;
  if (!counts) return {};
  const auto size = static_cast<double>(bytes.size());
  counts->vertices = std::clamp(counts->vertices, 0.0, size / kLeastVertexBytes);
  counts->triangles = std::clamp(counts->triangles, 0.0, size / kLeastTriangleBytes);
  counts->rows = std::clamp(counts->rows, 0.0, size / kLeastVertexBytes);
  return counts;
}

}  // namespace burnish
