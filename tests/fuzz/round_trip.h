// What every mesh that the decoders accept must survive.
#pragma once

#include "core/io/codec.h"

namespace burnish::fuzz {

/// Small enough that no input takes more than moments and megabytes.
inline constexpr Limits kLimits{.max_bytes = 64 << 10,
                                .max_vertices = 20'000,
                                .max_triangles = 20'000,
                                .max_attributes = 16,
                                .max_line_bytes = 8 << 10};

/// Estimates and decodes the bytes; smooths what is accepted by one step, writes it in every format, and
/// aborts when what was written cannot be read again.
void round_trip(std::string_view bytes, Format format);

}  // namespace burnish::fuzz
