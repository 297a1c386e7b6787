// Private to the Draco codec: what a file says of itself before the library decodes anything.
#pragma once

#include <draco/core/decoder_buffer.h>

#include <optional>

#include "core/io/draco.h"

namespace burnish {

/// Foreign numbers, true only if the rest of the file bears them out.
struct DracoCounts {
  std::uint32_t triangles = 0, points = 0;
};

/// An unsigned count in the file, in either of its two historical forms: four bytes, or as many as it needs.
bool read_count(draco::DecoderBuffer& buffer, bool plain, std::uint32_t* count);

/// The counts ahead of `buffer`, which is a copy that stands before the connectivity; nothing when it ends
/// too soon.
std::optional<DracoCounts> declared_counts(draco::DecoderBuffer buffer, DracoMethod method);

/// The file's method. Errors: MalformedMesh, NotATriangleMesh.
Result<DracoMethod> draco_method(std::string_view bytes);

/// The counts of a whole file, which need not be well-formed; nothing when it does not come to state them.
std::optional<DracoCounts> peek_counts(std::string_view bytes);

}  // namespace burnish
