// Private to the estimate: what a GLB says of itself, before anything is decoded.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace burnish {

/// Foreign numbers, true only if the rest of the file bears them out.
struct GlbCounts {
  double vertices = 0, triangles = 0;
};

/// What the accessors of its triangles declare. Nothing when its JSON takes more than `most_bytes`, or cannot
/// be read.
std::optional<GlbCounts> declared_glb_counts(std::string_view bytes, std::size_t most_bytes);

}  // namespace burnish
