#include "server/sandbox/filter.h"

#include <linux/sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

namespace burnish {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Sanitizers find out with a pipe whether memory is there.
constexpr int kAllowedSanitizers[] = {SCMP_SYS(pipe), SCMP_SYS(pipe2)};
constexpr int kAllowed[] = {
    // memory
    SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise), SCMP_SYS(membarrier),
    // threads
    SCMP_SYS(futex), SCMP_SYS(set_robust_list), SCMP_SYS(rseq), SCMP_SYS(sched_yield),
    SCMP_SYS(sched_getaffinity), SCMP_SYS(getcpu), SCMP_SYS(gettid), SCMP_SYS(getpid), SCMP_SYS(exit),
    SCMP_SYS(exit_group), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack), SCMP_SYS(restart_syscall),
    // clocks and chance
    SCMP_SYS(clock_gettime), SCMP_SYS(clock_getres), SCMP_SYS(clock_nanosleep), SCMP_SYS(nanosleep),
    SCMP_SYS(gettimeofday), SCMP_SYS(getrandom), SCMP_SYS(getrusage), SCMP_SYS(sysinfo),
    // the files that are open
    SCMP_SYS(read), SCMP_SYS(write), SCMP_SYS(readv), SCMP_SYS(writev), SCMP_SYS(pread64), SCMP_SYS(pwrite64),
    SCMP_SYS(lseek), SCMP_SYS(fstat), SCMP_SYS(ftruncate), SCMP_SYS(close), SCMP_SYS(poll), SCMP_SYS(ppoll),
    SCMP_SYS(sendmsg), SCMP_SYS(recvmsg), SCMP_SYS(sendto), SCMP_SYS(recvfrom)};

/// Of an argument, counted from 0. The library's own macros are C.
scmp_arg_cmp equal(unsigned argument, scmp_datum_t value) {
  return {.arg = argument, .op = SCMP_CMP_EQ, .datum_a = value, .datum_b = 0};
}
scmp_arg_cmp bits(unsigned argument, scmp_datum_t mask, scmp_datum_t value) {
  return {.arg = argument, .op = SCMP_CMP_MASKED_EQ, .datum_a = mask, .datum_b = value};
}

struct Filter {
  scmp_filter_ctx context = seccomp_init(SCMP_ACT_ERRNO(EPERM));
  int failure = context ? 0 : ENOMEM;

  ~Filter() {
    if (context) seccomp_release(context);
  }
  template <class... Condition>
  void allow(int call, Condition... conditions) {
    const int result = seccomp_rule_add(context, SCMP_ACT_ALLOW, call, sizeof...(conditions), conditions...);
    if (failure == 0 && result < 0) failure = -result;
  }
};

void limit(__rlimit_resource what, std::uint64_t most) {
  const rlimit both{.rlim_cur = most, .rlim_max = most};
  ::setrlimit(what, &both);
}

}  // namespace

Result<> give_up_rights(std::uint64_t max_memory) {
  limit(RLIMIT_CORE, 0);
  if (max_memory > 0 && !kSanitized) {  // the shadow of a sanitizer is larger than any limit
    limit(RLIMIT_DATA, max_memory);
    limit(RLIMIT_FSIZE, max_memory);  // of the buffer
  }
  Filter filter;
  if (filter.failure == 0) {
    for (const int call : kAllowed) filter.allow(call);
    if constexpr (kSanitized) {
      for (const int call : kAllowedSanitizers) filter.allow(call);
    }
    // No code but what is there, no process but this one.
    filter.allow(SCMP_SYS(mmap), bits(2, PROT_EXEC, 0));
    filter.allow(SCMP_SYS(mprotect), bits(2, PROT_EXEC, 0));
    filter.allow(SCMP_SYS(clone), bits(0, CLONE_THREAD, CLONE_THREAD));
    filter.allow(SCMP_SYS(tgkill), equal(0, static_cast<scmp_datum_t>(::getpid())));
    filter.allow(SCMP_SYS(prlimit64), equal(0, 0), equal(2, 0));  // asks, sets nothing
    // Its flags lie in memory, where no filter sees them; without it the C library uses clone().
    const int result = seccomp_rule_add(filter.context, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
    if (filter.failure == 0 && result < 0) filter.failure = -result;
  }
  // All threads; and without slowing down speculation, which guards programs that run foreign code.
  for (const auto attribute : {SCMP_FLTATR_CTL_TSYNC, SCMP_FLTATR_CTL_SSB}) {
    if (filter.failure == 0) filter.failure = -seccomp_attr_set(filter.context, attribute, 1);
  }
  if (filter.failure == 0) filter.failure = -seccomp_load(filter.context);
  if (filter.failure == 0) return {};
  return Error{Cause::Internal,
               "the kernel does not filter system calls here: " + std::string(std::strerror(filter.failure))};
}

}  // namespace burnish
