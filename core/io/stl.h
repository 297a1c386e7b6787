// STL, text and binary. Corners are not shared in the file: those at one position move as one.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// True when the bytes are as many as a binary STL that declares their count of facets has, or fewer than one
/// facet more.
bool has_binary_stl_size(std::string_view bytes);

}  // namespace burnish
