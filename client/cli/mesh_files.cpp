#include "client/cli/mesh_files.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>

namespace burnish::cli {

std::optional<Format> format_of_name(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension.empty()) return std::nullopt;
  return format_named(std::string_view(extension).substr(1));
}

Limits no_limits() {
  constexpr auto kAny = std::numeric_limits<std::uint64_t>::max();
  return {.max_bytes = kAny,
          .max_vertices = kNone,  // indices have 32 bits
          .max_triangles = kNone,
          .max_attributes = std::numeric_limits<std::uint32_t>::max(),
          .max_line_bytes = kAny};
}

}  // namespace burnish::cli
