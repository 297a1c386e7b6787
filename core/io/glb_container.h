// Private to the GLB codec: the container of a glTF 2.0 binary file, twelve bytes and then chunks.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/run/error.h"

namespace burnish {

/// Views of the file. Chunks end at a multiple of four bytes, filled up with spaces or zeros, which count.
struct GlbContainer {
  std::string_view json;
  std::optional<std::string_view> bin;
  std::string_view rest;  ///< further chunks, which glTF tells readers to pass over
};

/// Errors: MalformedMesh, UnsupportedFormat (glTF 1).
Result<GlbContainer> read_glb_container(std::string_view bytes);

/// Fills the chunks up where they need it. Errors: CannotEncode (4 GiB or more).
Result<std::string> write_glb_container(const GlbContainer& parts);

}  // namespace burnish
