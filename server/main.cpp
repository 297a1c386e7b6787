// burnishd: flags, signals, wiring.
#include <malloc.h>
#include <sys/auxv.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <future>
#include <string_view>
#include <system_error>
#include <thread>

#include <absl/synchronization/mutex.h>
#include <spdlog/spdlog.h>

#include "server/config.h"
#include "server/healthcheck.h"
#include "server/http/page.h"
#include "server/observe/log.h"
#include "server/sandbox/helper.h"
#include "server/server.h"
#include "server/status_map.h"

namespace {

/// Blocked before any thread starts, so that every thread inherits it and only main() takes signals.
sigset_t block_stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

/// Connections and spool files are open files; the usual soft limit of 1024 is for programs that use
/// select().
void allow_many_files() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
}

/// glibc otherwise moves this bound up to 32 MiB, so that what a large mesh leaves lies between the blocks of
/// the next: up to ten times its file's size after a few jobs, where seven and a half are enough. Fixing it
/// also fixes the bound above which free memory is given back, at 128 KiB, so that every small job would ask
/// for its memory anew. And blocks of hundreds of connections at once spread over eight arenas a core;
/// malloc_trim leaves the top of each but the first as it is, up to the bound for trimming.
void bound_what_malloc_keeps(int arenas) {
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 4 << 20);
  mallopt(M_ARENA_MAX, arenas);
}

/// glibc otherwise keeps up to 450 freed blocks per thread, each of which holds a page that cannot be given
/// back. It reads this when a program starts, so this one starts again; not where the environment says
/// something of its own, nor with rights that take the environment away.
void keep_no_blocks_per_thread(char** argv) {
  if (std::getenv("GLIBC_TUNABLES") != nullptr || getauxval(AT_SECURE) != 0) return;
  std::error_code failure;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", failure);
  if (failure || setenv("GLIBC_TUNABLES", "glibc.malloc.tcache_count=0", 1) != 0) return;
  execv(program.c_str(), argv);  // comes back when it cannot; then some more memory is kept
}

/// Debian builds Abseil, whose mutexes gRPC uses, with checks of the order in which they are locked: a graph
/// of all that there are, behind one lock.
void leave_locks_unchecked() { absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore); }

int report_health(const burnish::Config& config) {
  const auto healthy = burnish::check_health(config);
  if (healthy) return 0;
  std::fprintf(stderr, "burnishd: not ready: %s\n", healthy.error().message.c_str());
  return 1;
}

/// Drains; one more signal cuts the grace period short.
void stop(burnish::Server& server, std::chrono::seconds grace, const sigset_t& signals) {
  auto draining = std::async(std::launch::async, [&] { return server.stop(grace); });
  const timespec tick{.tv_sec = 0, .tv_nsec = 20'000'000};
  while (draining.wait_for(std::chrono::seconds::zero()) != std::future_status::ready) {
    if (sigtimedwait(&signals, nullptr, &tick) > 0) server.stop(std::chrono::seconds::zero());
  }
  draining.get();
}

}  // namespace

int main(int argc, char** argv) {
  const sigset_t signals = block_stop_signals();
  leave_locks_unchecked();
  const int per_core = static_cast<int>(std::max(2U, std::thread::hardware_concurrency()));
  if (argc == 2 && std::string_view(argv[1]) == burnish::kHelperArgument) {
    bound_what_malloc_keeps(per_core);
    return burnish::run_helper();
  }
  keep_no_blocks_per_thread(argv);  // before anything is read: settings may come through a pipe
  auto parsed = burnish::parse_config(argc, argv);
  if (const int* exit_code = std::get_if<int>(&parsed)) return *exit_code;
  auto& config = std::get<burnish::Config>(parsed);
  if (config.health_check) return report_health(config);
  bound_what_malloc_keeps(config.sandbox ? 1 : per_core);  // helpers work on meshes, this one passes them on
  config.helper_program = "/proc/self/exe";  // this very program, also when its file was replaced
  config.page = burnish::page_files();
  burnish::set_up_log(config.log_level);
  allow_many_files();

  const auto server = burnish::Server::start(config);
  if (!server) {
    std::fprintf(stderr, "burnishd: %s\n", server.error().message.c_str());
    return burnish::status_of(server.error().cause).exit_code;
  }
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("signal {}: stopping within {} s", signal, config.grace.count());
  stop(*server.value(), config.grace, signals);
  return 0;
}
