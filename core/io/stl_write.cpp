#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/io/stl_document.h"
#include "core/io/text_number.h"
#include "core/io/text_scan.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr int kUnitDecimals = 6;  // of normals
constexpr std::size_t kNormalBytes = 12;

/// The first of the facet's 12 floats that belongs to a corner.
std::size_t corner_offset(std::size_t corner) { return kNormalBytes * (corner + 1); }

void store(char* at, const Vec3f& v) {
  const std::array<float, 3> numbers{v.x, v.y, v.z};
  std::memcpy(at, numbers.data(), sizeof numbers);
}

/// Stores a position as floats; returns how far they are from it.
double store_position(char* at, const Vec3d& position) {
  const Vec3f narrow{stl_float(position.x), stl_float(position.y), stl_float(position.z)};
  store(at, narrow);
  return length(to_double(narrow) - position);
}

bool is_zero(const char* normal) {
  std::array<float, 3> numbers{};
  std::memcpy(numbers.data(), normal, sizeof numbers);
  return std::ranges::all_of(numbers, [](float n) { return n == 0; });
}

bool says_something(std::string_view header) {
  return header.find_first_not_of(std::string_view(" \t\r\n\0", 5)) != std::string_view::npos;
}

}  // namespace

float stl_float(double value) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kMost, kMost));
}

Vec3f stl_normal(const MovedPositions& moved, const Triangle& facet) {
  const auto at = [&](Index v) { return to_double(moved.after[moved.weld[v]]); };
  const Vec3d normal = cross(at(facet[1]) - at(facet[0]), at(facet[2]) - at(facet[0]));
  const double size = length(normal);
  return size > 0 ? to_float(normal * (1 / size)) : Vec3f{};
}

std::string StlDocument::vertex_place(Index vertex) const {
  return "vertex " + std::to_string(vertex) + " of " + triangle_place(first_facet_[vertex]);
}

std::string StlDocument::triangle_place(Index triangle) const {
  const std::uint64_t begin = facet_begin(triangle);
  return "facet " + std::to_string(triangle + 1) +
         (text_ ? line_place(bytes_, begin) : " (byte " + std::to_string(begin) + ')');
}

bool StlDocument::moved_facet(const MovedPositions& moved, Index facet) const {
  return std::ranges::any_of(triangles_[facet], [&](Index v) { return moved.moved(v); });
}

Result<Encoded> StlDocument::encode_same(const MovedPositions& moved, const OutputOptions&,
                                         const RunControl& run) const {
  Encoded encoded;
  if (text_) {
    auto text = patch_text(moved, run);
    if (!text) return text.error();
    encoded.bytes = std::move(*text);
    encoded.quantisation_error = DecimalWriter(moved.frame).largest_error();
    return encoded;
  }
  encoded.bytes = bytes_;
  const bool done = for_each(triangles_.size(), run.on_one_thread(), [&](std::size_t t) {
    const auto facet = static_cast<Index>(t);
    if (!moved_facet(moved, facet)) return;
    char* const at = &encoded.bytes[facet_begin(facet)];
    for (std::size_t c = 0; c < 3; ++c) {
      const Index v = triangles_[t][c];
      if (!moved.moved(v)) continue;
      const double off = store_position(at + corner_offset(c), moved.at(v));
      encoded.quantisation_error = std::max(encoded.quantisation_error, off);
    }
    const Vec3f normal = stl_normal(moved, triangles_[t]);
    if (!(normal == Vec3f{}) && !is_zero(at)) store(at, normal);
  });
  if (!done) return run.stop_error();
  return encoded;
}

Result<std::string> StlDocument::patch_text(const MovedPositions& moved, const RunControl& run) const {
  const DecimalWriter coordinates(moved.frame), units(kUnitDecimals);
  Patcher patcher(bytes_, 0, bytes_.size());
  const bool done = for_each(triangles_.size(), run.on_one_thread(), [&](std::size_t t) {
    const auto facet = static_cast<Index>(t);
    if (!moved_facet(moved, facet)) return;
    TextScanner scanner(bytes_, facet_begins_[facet], false);
    const auto skip_words = [&](int count) {
      for (; count > 0 && scanner.find_word(); --count) scanner.word();
    };
    const auto next_word = [&]() -> TextRange {
      scanner.find_word();
      const std::uint64_t begin = scanner.offset();
      return {begin, scanner.word().size()};
    };
    skip_words(1);  // normal
    std::array<TextRange, 3> words;
    bool zero = true;
    for (TextRange& word : words) {
      scanner.find_word();
      TextScanner copy = scanner;
      double value = 0;
      zero &= copy.number(value) && value == 0;
      word = next_word();
    }
    const Vec3f normal = stl_normal(moved, triangles_[t]);
    for (std::size_t axis = 0; axis < 3 && !zero && !(normal == Vec3f{}); ++axis)
      units.append(patcher.replace(words[axis]), static_cast<double>(normal[axis]));
    skip_words(2);  // outer loop
    for (const Index v : triangles_[t]) {
      skip_words(1);  // vertex
      const Vec3d position = moved.at(v);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const TextRange word = next_word();
        if (moved.moved(v)) coordinates.append(patcher.replace(word), position[axis]);
      }
    }
  });
  if (!done) return run.stop_error();
  return std::move(patcher).finish();
}

/// A facet's normal is no attribute of vertices: who reads the result computes it again.
Result<SharedAttributes> StlDocument::shared_attributes(const MovedPositions&, const RunControl& run) const {
  SharedAttributes shared;
  if (text_) {
    if (has_names_) shared.dropped.emplace_back("names of solids");
    return shared;
  }
  if (says_something(bytes_.substr(0, kStlHeaderBytes))) shared.dropped.emplace_back("the header's text");
  bool any = false;
  const bool done = for_each(triangles_.size(), run.on_one_thread(), [&](std::size_t t) {
    const std::uint64_t end = facet_begin(static_cast<Index>(t)) + kStlFacetBytes;
    any |= bytes_[end - 2] != 0 || bytes_[end - 1] != 0;
  });
  if (!done) return run.stop_error();
  if (any) shared.dropped.emplace_back("attribute bytes of facets");
  return shared;
}

Result<Encoded> encode_as_stl(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const RunControl& run) {
  Encoded encoded;
  encoded.bytes = "binary STL";
  encoded.bytes.resize(kStlHeaderBytes, ' ');
  encoded.bytes.resize(kFirstStlFacet + triangles.size() * kStlFacetBytes, '\0');
  const auto count = static_cast<std::uint32_t>(triangles.size());
  std::memcpy(&encoded.bytes[kStlHeaderBytes], &count, sizeof count);
  std::vector<std::uint8_t> used(moved.after.size(), 0);
  const bool done = for_each(triangles.size(), run.on_one_thread(), [&](std::size_t t) {
    char* const at = &encoded.bytes[kFirstStlFacet + t * kStlFacetBytes];
    store(at, stl_normal(moved, triangles[t]));
    for (std::size_t c = 0; c < 3; ++c) {
      const Index v = triangles[t][c];
      used[moved.weld[v]] = 1;
      const double off = store_position(at + corner_offset(c), moved.at(v));
      encoded.quantisation_error = std::max(encoded.quantisation_error, off);
    }
  });
  if (!done) return run.stop_error();
  const auto kept = static_cast<std::uint32_t>(std::ranges::count(used, 1));
  encoded.vertices = kept;
  if (const auto lost = static_cast<std::uint32_t>(used.size()) - kept; lost > 0) {
    encoded.warnings.push_back({"vertices_dropped",
                                std::to_string(lost) + (lost == 1 ? " vertex is" : " vertices are") +
                                    " in no triangle, and STL holds nothing else",
                                lost});
  }
  return encoded;
}

}  // namespace burnish
