// What the head of a file says of its size, for the estimate of what it will take.
#pragma once

#include <optional>
#include <string_view>

#include "core/io/format.h"

namespace burnish {

struct DeclaredCounts {
  double vertices = 0, triangles = 0;
  double rows = 0;           ///< normals and texture coordinates, each counted for itself
  double written_bytes = 1;  ///< of the result in the same format, for each byte of the file
};

/// Of PLY, STL and OFF; reads 64 KiB at the most. Never more than the bytes could hold. Nothing: another
/// format, or a head that cannot be read. Thread-safe; never throws.
std::optional<DeclaredCounts> declared_counts(std::string_view bytes, Format format);

}  // namespace burnish
