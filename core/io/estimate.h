// What a file will take, told from its size and header before anything is decoded.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/io/codec.h"

namespace burnish {

struct Estimate {
  /// Peak of decoding, measuring and encoding in either format, and of smoothing with a method that needs
  /// little; the file's own bytes apart.
  std::uint64_t memory_bytes = 0;
  std::uint64_t vertices = 0, triangles = 0;  ///< about

  /// The peak when smoothing takes so much beside the surface.
  std::uint64_t memory_with(std::uint64_t smoothing_bytes) const;
};

/// Reads 64 KiB at most (of a GLB its JSON, if that takes 1 MiB at most): of an OBJ a sample of its lines, of
/// other formats the declared counts. Well-formed
/// files are hardly underestimated and at most taken for twice what they are; estimate.cpp says how that was
/// measured. What a hostile file hides from it is bounded by Limits alone. Bytes that are no mesh give what
/// their size would give. Thread-safe; never throws.
Estimate estimate(std::string_view bytes, std::optional<Format> format);

/// Before the bytes are there: the least that well-formed files of this size take, so that nothing is refused
/// which would fit. Unset: the cheaper format.
Estimate estimate(std::uint64_t bytes, std::optional<Format> format);

}  // namespace burnish
