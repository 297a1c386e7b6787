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
  if (extension == ".obj") return Format::Obj;
  if (extension == ".drc") return Format::Draco;
  return std::nullopt;
}

Limits no_limits() { return {.max_bytes = std::numeric_limits<std::uint64_t>::max()}; }

}  // namespace burnish::cli
