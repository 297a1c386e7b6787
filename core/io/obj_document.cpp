#include "core/io/obj_document.h"

#include <fast_float/fast_float.h>

#include <algorithm>
#include <array>

#include "core/io/obj_statements.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Up to N numbers from a stretch of text; what is missing or no number is 0.
template <std::size_t N>
std::array<float, N> read_numbers(std::string_view text) {
  std::array<float, N> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (float& number : numbers) {
    while (at != end &&
           (*at == ' ' || *at == '\t' || *at == '\\' || *at == '\r' || *at == '\n' || *at == '+'))
      ++at;
    const auto [stop, failure] = fast_float::from_chars(at, end, number);
    if (failure != std::errc() || !std::isfinite(number)) number = 0;
    if (failure != std::errc()) break;
    at = stop;
  }
  return numbers;
}

/// The text from `begin` to the end of its line or to a comment.
std::string_view rest_of_line(std::string_view text, std::uint64_t begin) {
  const std::size_t end = text.find_first_of("\r\n#", begin);
  return text.substr(begin, end == std::string_view::npos ? end : end - begin);
}

}  // namespace

std::string ObjDocument::vertex_place(Index vertex) const {
  return "vertex " + std::to_string(vertex + 1) + " (line " +
         std::to_string(line_at(text_, vertex_text_[vertex].begin)) + ')';
}

std::string ObjDocument::triangle_place(Index triangle) const {
  const Index face = face_of_triangle_.empty() ? triangle : face_of_triangle_[triangle];
  // Only messages ask, so the faces are counted again instead of remembered.
  ObjStatements statements(text_);
  std::string_view keyword = statements.keyword();
  for (Index seen = 0; keyword != "f" || seen++ != face; keyword = statements.keyword()) {
    statements.skip_line();
    if (statements.at_end()) break;
  }
  const auto offset = static_cast<std::uint64_t>(keyword.data() - text_.data());
  return "face " + std::to_string(face + 1) + " (line " + std::to_string(line_at(text_, offset)) + ')';
}

Result<SharedAttributes> ObjDocument::shared_attributes(const MovedPositions& moved,
                                                        const RunControl& run) const {
  SharedAttributes shared;
  if (!corner_normals_.empty()) {
    auto fresh = corner_normals(moved, triangles_, corner_normals_, normal_text_.size(), run);
    if (!fresh) return fresh.error();
    MeshAttribute normals{3, {}, corner_normals_};
    for (std::size_t row = 0; row < normal_text_.size(); ++row) {
      auto values = read_numbers<3>(text_.substr(normal_text_[row].begin, normal_text_[row].length));
      const Vec3f& n = fresh->normals[row];
      if (fresh->touched[row] && !(n == Vec3f{})) values = {n.x, n.y, n.z};
      normals.values.insert(normals.values.end(), values.begin(), values.end());
    }
    shared.normals = std::move(normals);
  }
  if (!corner_textures_.empty()) {
    MeshAttribute textures{2, {}, corner_textures_};
    for (const TextRange& range : texture_text_) {
      const auto values = read_numbers<2>(text_.substr(range.begin, range.length));
      textures.values.insert(textures.values.end(), values.begin(), values.end());
    }
    shared.texture_coordinates = std::move(textures);
  }
  bool any_color = false;
  std::vector<float> colors;
  for (const TextRange& range : vertex_text_) {
    const auto rest = rest_of_line(text_, range.begin + range.length);
    any_color |= rest.find_first_not_of(" \t") != std::string_view::npos;
    const auto values = read_numbers<3>(rest);
    colors.insert(colors.end(), values.begin(), values.end());
  }
  if (any_color) shared.colors = std::move(colors);
  if (!face_of_triangle_.empty()) shared.dropped.push_back("polygons (split into triangles)");
  if (has_more_) shared.dropped.push_back("groups, materials and other statements");
  return shared;
}

}  // namespace burnish
