#include "server/observe/memory_limit.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

namespace burnish {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kUnknown = std::uint64_t{1} << 30;

/// The number that the file holds; "max" and missing files are no limit.
std::uint64_t limit_in(const fs::path& file) {
  std::ifstream stream(file);
  std::uint64_t limit = 0;
  return stream >> limit ? limit : kUnlimited;
}

/// The least limit of the group and of those around it. A container may see the group's path but not its
/// folder.
std::uint64_t least_limit(const fs::path& root, std::string_view group, const char* file) {
  std::uint64_t least = limit_in(root / file);
  fs::path folder = root;
  for (const fs::path& part : fs::path(group).relative_path()) {
    folder /= part;
    least = std::min(least, limit_in(folder / file));
  }
  return least;
}

/// Whether a comma-separated list names the memory controller.
bool rules_memory(std::string_view controllers) {
  return ("," + std::string(controllers) + ",").find(",memory,") != std::string::npos;
}

std::uint64_t cgroup_limit(const MemorySources& sources) {
  std::uint64_t least = kUnlimited;
  std::ifstream groups(sources.own_cgroups);
  for (std::string line; std::getline(groups, line);) {  // "0::/group" or "4:memory:/group"
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string_view controllers = std::string_view(line).substr(first + 1, second - first - 1);
    const std::string_view group = std::string_view(line).substr(second + 1);
    if (controllers.empty()) least = std::min(least, least_limit(sources.cgroups, group, "memory.max"));
    if (rules_memory(controllers)) {
      least = std::min(least, least_limit(sources.cgroups / "memory", group, "memory.limit_in_bytes"));
    }
  }
  return least;
}

std::uint64_t machine_memory(const fs::path& file) {
  std::ifstream stream(file);
  for (std::string word; stream >> word;) {
    std::uint64_t kibibytes = 0;
    if (word == "MemTotal:" && stream >> kibibytes) return kibibytes << 10;
  }
  return kUnlimited;
}

}  // namespace

std::uint64_t usable_memory(const MemorySources& sources) {
  const std::uint64_t least = std::min(cgroup_limit(sources), machine_memory(sources.machine));
  return least == kUnlimited ? kUnknown : least;
}

}  // namespace burnish
