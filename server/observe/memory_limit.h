// How much memory this process may use.
#pragma once

#include <cstdint>
#include <filesystem>

namespace burnish {

/// Where the kernel tells; other folders serve tests.
struct MemorySources {
  std::filesystem::path cgroups = "/sys/fs/cgroup";         ///< of version 2 or 1
  std::filesystem::path own_cgroups = "/proc/self/cgroup";  ///< where in them this process is
  std::filesystem::path machine = "/proc/meminfo";
};

/// In bytes: the least limit of the cgroups that this process is in, or the machine's memory when none is
/// lower. What cannot be read counts as no limit; without any answer 1 GiB.
std::uint64_t usable_memory(const MemorySources& sources = {});

}  // namespace burnish
