// Private to the GLB codec: the JSON of a glTF as a tree of what the codec asks for, and where in its text a
// value stands, so that single numbers can be replaced and all else comes back byte for byte.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/text_scan.h"
#include "core/run/run_control.h"

namespace burnish {

/// A value. The members of an object keep their order, and no name comes twice.
struct JsonValue {
  enum class Kind : std::uint8_t { Null, Boolean, Number, String, Array, Object };

  Kind kind = Kind::Null;
  double number = 0;
  std::string name = {};  ///< as a member of an object
  std::string text = {};  ///< of a string
  std::vector<JsonValue> items = {};

  bool is(Kind wanted) const { return kind == wanted; }
  const JsonValue* find(std::string_view member) const;  ///< null when there is none, or this is no object
};

/// Reads the JSON of a glTF. Of the root's members those that tell of meshes come whole, the others as null
/// without what they hold, and so do "extras" and the rest that only carries through; their syntax is checked
/// all the same. Errors: MalformedMesh, TooLarge (nested deeper than 64 levels, or more than a million
/// values), Cancelled, DeadlineExceeded.
Result<JsonValue> parse_gltf_json(std::string_view text, const RunControl& run);

/// Below: `text` has passed parse_gltf_json(), and a range is where a value of it stands.
TextRange json_root(std::string_view text);
/// Nothing when the object has no such member, or is no object.
std::optional<TextRange> json_member(std::string_view text, TextRange object, std::string_view name);
/// Empty for what is no array.
std::vector<TextRange> json_elements(std::string_view text, TextRange array);

}  // namespace burnish
