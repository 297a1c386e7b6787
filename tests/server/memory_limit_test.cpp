#include "server/observe/memory_limit.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/client/temporary_folder.h"

namespace burnish {
namespace {

constexpr std::uint64_t kMachine = 8000ull << 10;  // bytes of the "MemTotal: 8000 kB" below

struct Row {
  const char* what;
  std::string own_cgroups;
  std::vector<std::pair<std::string, std::string>> limits;  ///< file below the cgroups' folder, content
  std::uint64_t usable;
};

std::uint64_t usable(const Row& row) {
  const cli::TemporaryFolder folder;
  for (const auto& [file, content] : row.limits) {
    std::filesystem::create_directories(std::filesystem::path(folder / file).parent_path());
    folder.write(file, content);
  }
  return usable_memory({.cgroups = folder / "",
                        .own_cgroups = folder.write("own", row.own_cgroups),
                        .machine = folder.write("meminfo", "MemFree: 10 kB\nMemTotal:  8000 kB\n")});
}

TEST(MemoryLimit, IsTheLeastOfCgroupsAndMachine) {
  const std::string v1 = "3:cpu,cpuacct:/job\n2:blkio,memory:/job\n1:name=systemd:/\n";
  for (const Row& row : {
           Row{"no cgroup", "", {}, kMachine},
           Row{"version 2, own limit", "0::/a/b\n", {{"a/b/memory.max", "1000000\n"}}, 1000000},
           Row{"version 2, a parent's limit",
               "0::/a/b\n",
               {{"a/memory.max", "500000\n"}, {"a/b/memory.max", "1000000\n"}},
               500000},
           Row{"version 2, a container sees its limit at the root",
               "0::/\n",
               {{"memory.max", "700000\n"}},
               700000},
           Row{"version 2, no limit", "0::/a\n", {{"a/memory.max", "max\n"}}, kMachine},
           Row{"version 2, more than there is", "0::/a\n", {{"a/memory.max", "99999999999\n"}}, kMachine},
           Row{"version 2, another group's limit", "0::/a\n", {{"b/memory.max", "1000\n"}}, kMachine},
           Row{"version 1", v1, {{"memory/job/memory.limit_in_bytes", "600000\n"}}, 600000},
           Row{"version 1, the host's path in a container",
               v1,
               {{"memory/memory.limit_in_bytes", "400000\n"}},
               400000},
           Row{"version 1, no limit",
               v1,
               {{"memory/job/memory.limit_in_bytes", "9223372036854771712\n"}},
               kMachine},
           Row{"not a list of groups", "nonsense\n:\n", {{"memory.max", "1000\n"}}, kMachine},
       }) {
    EXPECT_EQ(usable(row), row.usable) << row.what;
  }
}

TEST(MemoryLimit, IsAGuessWithoutAnyAnswer) {
  EXPECT_EQ(usable_memory({.cgroups = "/none", .own_cgroups = "/none", .machine = "/none"}), 1u << 30);
}

TEST(MemoryLimit, KnowsThisMachine) {
  EXPECT_GT(usable_memory(), 64u << 20);
  EXPECT_LT(usable_memory(), std::uint64_t{1} << 50);
}

}  // namespace
}  // namespace burnish
