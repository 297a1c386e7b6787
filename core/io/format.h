// The mesh formats: how each is called, and how the bytes of a file tell which it is.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace burnish {

enum class Format : std::uint8_t { Obj, Draco, Ply, Stl, Off, Glb };

/// What everybody who names, lists or chooses formats must know of one. A new format is a row here, a row of
/// codecs in codec.cpp and a value of MeshFormat.
struct FormatTraits {
  Format format = Format::Obj;
  std::string_view name;   ///< "ply": in options, queries and reports, and the ending of file names
  std::string_view title;  ///< "a PLY", as messages say it
  std::string_view media_type;
  std::span<const std::string_view> other_media_types;  ///< that are understood too
  bool may_be_text = false;                             ///< worth compressing when the bytes are text
  // What SharedAttributes has and a file of this format can hold.
  bool carries_normals = true, carries_texture_coordinates = true, carries_colors = true;
};

std::span<const FormatTraits> formats();  ///< in the order of the enum
const FormatTraits& traits_of(Format format);
std::string_view format_name(Format format);                        ///< "obj", "drc"
std::optional<Format> format_named(std::string_view name);          ///< by its name, in lower case
std::optional<Format> format_of_media_type(std::string_view type);  ///< in lower case, without parameters

/// "obj, drc or ply" of all names, "model/obj, ... or model/ply" of all media types.
std::string list_of_format_names();
std::string list_of_media_types();

/// True unless the first 4096 bytes hold a control character that no text has.
bool looks_like_text(std::string_view bytes);

/// U+FEFF in UTF-8, which some programs put before text.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
/// The bytes behind a byte order mark; all of them where there is none, or where the format has bytes of its
/// own in that place.
std::string_view behind_byte_order_mark(std::string_view bytes, Format format);

/// Tells the format by content, behind a byte order mark: the signatures of Draco, glTF binary and PLY, the
/// size of a binary STL, the first word of OFF and of text STL, else OBJ when it looks like text; nothing
/// when it is none of them. Reads 64 KiB at most.
std::optional<Format> detect_format(std::string_view bytes);

}  // namespace burnish
