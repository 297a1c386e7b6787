#include "server/sandbox/helper_process.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <vector>

#include "server/sandbox/helper.h"

namespace burnish {
namespace {

constexpr int kAboveHelperFiles = 16;

/// A copy above the numbers that the helper's files get, so that none is overwritten by another.
int lift(const File& file) { return ::fcntl(file.get(), F_DUPFD_CLOEXEC, kAboveHelperFiles); }

/// Of the environment what the program loader and the sanitizers read. Without pages of 2 MiB the kernel
/// takes as long to hand out the memory for a large mesh as the helper takes to work on it.
std::vector<char*> helper_environment() {
  static std::string large_pages = "GLIBC_TUNABLES=glibc.malloc.hugetlb=1";
  std::vector<char*> kept;
  for (char** each = environ; *each; ++each) {
    const std::string_view entry = *each;
    const std::string_view name = entry.substr(0, entry.find('='));
    if (name.starts_with("LD_") || name.ends_with("SAN_OPTIONS")) kept.push_back(*each);
  }
  kept.push_back(large_pages.data());
  kept.push_back(nullptr);
  return kept;
}

}  // namespace

Result<std::unique_ptr<HelperProcess>> HelperProcess::start(const std::string& program) {
  auto [jobs, their_jobs] = Channel::pair();
  auto [cancels, their_cancels] = Channel::pair();
  File input = SharedBuffer::make("burnish-input"), output = SharedBuffer::make("burnish-output");
  if (!jobs.is_open() || !cancels.is_open() || !input.is_open() || !output.is_open())
    return Error{Cause::Internal, "cannot prepare a helper process: " + std::string(std::strerror(errno))};
  std::unique_ptr<HelperProcess> helper(
      new HelperProcess(std::move(jobs), std::move(cancels), std::move(input), std::move(output)));

  const File lifted[] = {File::adopt(lift(their_jobs)), File::adopt(lift(their_cancels)),
                         File::adopt(lift(helper->input_.file())), File::adopt(lift(helper->output_.file()))};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  const int targets[] = {kHelperJobs, kHelperCancels, kHelperInput, kHelperOutput};
  for (std::size_t i = 0; i < std::size(targets); ++i)
    posix_spawn_file_actions_adddup2(&actions, lifted[i].get(), targets[i]);
  std::string name = "burnishd", argument = kHelperArgument;
  char* const arguments[] = {name.data(), argument.data(), nullptr};
  const std::vector<char*> environment = helper_environment();
  const int failure =
      ::posix_spawn(&helper->id_, program.c_str(), &actions, nullptr, arguments, environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    helper->id_ = -1;
    return Error{Cause::Internal, "cannot start a helper process: " + std::string(std::strerror(failure))};
  }
  return helper;
}

HelperProcess::~HelperProcess() { end(); }

std::string HelperProcess::end() {
  if (id_ < 0) return ending_;
  int status = 0;
  pid_t ended = ::waitpid(id_, &status, WNOHANG);
  if (ended == 0) {
    ::kill(id_, SIGKILL);
    do ended = ::waitpid(id_, &status, 0);
    while (ended < 0 && errno == EINTR);
  }
  id_ = -1;
  ending_ = ended < 0 ? "gone"
            : WIFSIGNALED(status)
                ? "signal " + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) + ")"
                : "exit " + std::to_string(WEXITSTATUS(status));
  return ending_;
}

std::uint64_t HelperProcess::resident_bytes() const {
  std::ifstream file("/proc/" + std::to_string(id_) + "/statm");
  std::uint64_t size = 0, resident = 0;
  if (id_ < 0 || !(file >> size >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace burnish
