#include "core/io/format.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "core/io/stl.h"

namespace burnish {
namespace {

constexpr std::size_t kSeenBytes = 64 << 10;

// What other programs and older servers call them.
constexpr std::array<std::string_view, 3> kPlyTypes{"application/ply", "application/x-ply", "text/ply"};
constexpr std::array<std::string_view, 5> kStlTypes{"model/x.stl-binary", "model/x.stl-ascii",
                                                    "application/sla", "application/vnd.ms-pki.stl",
                                                    "application/x-stl"};
constexpr std::array<std::string_view, 2> kOffTypes{"application/off", "application/x-off"};

constexpr std::array<FormatTraits, 6> kFormats{{
    {.format = Format::Obj,
     .name = "obj",
     .title = "an OBJ",
     .media_type = "model/obj",
     .other_media_types = {},
     .may_be_text = true},
    {.format = Format::Draco,
     .name = "drc",
     .title = "a Draco mesh",
     .media_type = "model/vnd.draco",
     .other_media_types = {}},
    {.format = Format::Ply,
     .name = "ply",
     .title = "a PLY",
     .media_type = "model/ply",
     .other_media_types = kPlyTypes,
     .may_be_text = true},
    {.format = Format::Stl,
     .name = "stl",
     .title = "an STL",
     .media_type = "model/stl",
     .other_media_types = kStlTypes,
     .may_be_text = true,
     .carries_normals = false,
     .carries_texture_coordinates = false,
     .carries_colors = false},
    {.format = Format::Off,
     .name = "off",
     .title = "an OFF",
     .media_type = "model/off",
     .other_media_types = kOffTypes,
     .may_be_text = true,
     .carries_normals = false,
     .carries_texture_coordinates = false},
    {.format = Format::Glb,
     .name = "glb",
     .title = "a glTF binary",
     .media_type = "model/gltf-binary",
     .other_media_types = {}},
}};

static_assert(std::ranges::all_of(kFormats, [](const FormatTraits& traits) {
  return &traits == &kFormats[static_cast<std::size_t>(traits.format)];
}));

template <class Name>
std::string list_of(Name FormatTraits::*member) {
  std::string list;
  for (const FormatTraits& each : kFormats) {
    const bool last = &each == &kFormats.back();
    list.append(list.empty() ? "" : last ? " or " : ", ").append(each.*member);
  }
  return list;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\f' || c == '\v'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// Cuts the first line off, without its end.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

std::string_view first_word(std::string_view line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  const auto end = std::ranges::find_if(line, is_blank);
  return line.substr(0, static_cast<std::size_t>(end - line.begin()));
}

bool same_word(std::string_view word, std::string_view lower_case) {
  return std::ranges::equal(word, lower_case,
                            [](unsigned char a, unsigned char b) { return std::tolower(a) == b; });
}

/// A signature that the free text at the head of a binary STL begins with by chance goes on as text.
bool has_signature(std::string_view bytes, std::string_view signature) {
  if (!bytes.starts_with(signature)) return false;
  const bool goes_on_as_text =
      bytes.size() > signature.size() && static_cast<unsigned char>(bytes[signature.size()]) >= ' ';
  return !(goes_on_as_text && has_binary_stl_size(bytes));
}

std::string_view behind_byte_order_mark(std::string_view bytes) {
  return bytes.substr(bytes.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
}

/// "ply" alone on the first line.
bool is_ply(std::string_view head) {
  std::string_view rest = head;
  std::string_view line = take_line(rest);
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return line == "ply";
}

/// "solid" is the first word, and no statement of OBJ comes before one of STL.
bool is_text_stl(std::string_view head) {
  bool solid = false;
  while (!head.empty()) {
    const std::string_view word = first_word(take_line(head));
    if (word.empty()) continue;
    if (!solid) {
      if (!same_word(word, "solid")) return false;
      solid = true;
    } else if (same_word(word, "facet") || same_word(word, "endsolid")) {
      return true;
    } else if (word == "v" || word == "vn" || word == "vt" || word == "f") {
      return false;
    }
  }
  return solid;
}

/// "OFF" with any of its prefixes is the first word behind comments.
bool is_off(std::string_view head) {
  while (!head.empty()) {
    std::string_view word = first_word(take_line(head));
    if (word.empty() || word.front() == '#') continue;
    for (const std::string_view prefix : {"ST", "C", "N", "4", "n"}) {
      if (word.starts_with(prefix)) word.remove_prefix(prefix.size());
    }
    return word.substr(0, word.find('#')) == "OFF";
  }
  return false;
}

}  // namespace

std::span<const FormatTraits> formats() { return kFormats; }

const FormatTraits& traits_of(Format format) { return kFormats[static_cast<std::size_t>(format)]; }

std::string_view format_name(Format format) { return traits_of(format).name; }

std::optional<Format> format_named(std::string_view name) {
  const auto found = std::ranges::find(kFormats, name, &FormatTraits::name);
  return found == kFormats.end() ? std::nullopt : std::optional(found->format);
}

std::optional<Format> format_of_media_type(std::string_view type) {
  for (const FormatTraits& each : kFormats) {
    if (type == each.media_type ||
        std::ranges::find(each.other_media_types, type) != each.other_media_types.end())
      return each.format;
  }
  return std::nullopt;
}

std::string list_of_format_names() { return list_of(&FormatTraits::name); }

std::string list_of_media_types() { return list_of(&FormatTraits::media_type); }

bool looks_like_text(std::string_view bytes) {
  return std::ranges::none_of(bytes.substr(0, 4096), [](char c) {
    return static_cast<unsigned char>(c) < ' ' && !is_blank(c) && !is_line_end(c);
  });
}

std::string_view behind_byte_order_mark(std::string_view bytes, Format format) {
  const bool binary = !traits_of(format).may_be_text || (format == Format::Stl && has_binary_stl_size(bytes));
  return binary ? bytes : behind_byte_order_mark(bytes);
}

std::optional<Format> detect_format(std::string_view bytes) {
  if (has_signature(bytes, "DRACO")) return Format::Draco;
  if (has_signature(bytes, "glTF")) return Format::Glb;
  const std::string_view behind = behind_byte_order_mark(bytes), head = behind.substr(0, kSeenBytes);
  if (is_ply(head)) return Format::Ply;
  if (has_binary_stl_size(bytes)) return Format::Stl;
  if (is_off(head)) return Format::Off;
  const bool text = looks_like_text(behind);
  if (is_text_stl(head)) return Format::Stl;
  if (text) return Format::Obj;
  // A binary STL that was cut off: its own reader tells how.
  if (same_word(bytes.substr(0, 5), "solid") || is_cut_binary_stl(bytes)) return Format::Stl;
  return std::nullopt;
}

}  // namespace burnish
