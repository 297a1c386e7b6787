// A place in a file's text or bytes.
#pragma once

#include <cstdint>

namespace burnish {

/// A stretch of a file.
struct TextRange {
  std::uint64_t begin = 0;
  std::uint64_t length = 0;
};

}  // namespace burnish
