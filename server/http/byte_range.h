// Range requests of one range (RFC 9110, section 14).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/run/error.h"

namespace burnish {

struct ByteRange {
  std::uint64_t first = 0, size = 0;
  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

/// The part of `size` bytes that "bytes=0-99", "bytes=100-" or "bytes=-100" asks for. Nothing: all of them,
/// also for a header that cannot be understood or asks for several parts. Errors: RangeNotSatisfiable.
Result<std::optional<ByteRange>> parse_range(std::string_view header, std::uint64_t size);

}  // namespace burnish
