// File names and mesh formats.
#pragma once

#include <optional>
#include <string>

#include "core/io/codec.h"

namespace burnish::cli {

/// The format that the name's extension promises, such as .obj or .drc, in either case; else nothing.
std::optional<Format> format_of_name(const std::string& path);

/// Files on one's own machine are not limited; memory is.
Limits no_limits();

}  // namespace burnish::cli
