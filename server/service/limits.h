// What one request may ask for.
#pragma once

#include <cstdint>

#include "core/io/codec.h"

namespace burnish {

/// Each is a flag of burnishd, spelt as the member with dashes, and is named so in the error.
struct RequestLimits {
  Limits mesh = {};  ///< of the mesh and of the reference, each
  std::uint32_t max_iterations = 100'000;
  std::uint64_t max_option_bytes = 64 << 10;  ///< of the options, serialised
};

}  // namespace burnish
