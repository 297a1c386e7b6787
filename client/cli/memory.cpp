#include "client/cli/memory.h"

#include <malloc.h>
#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>

namespace burnish::cli {

void keep_memory() {
  mallopt(M_MMAP_MAX, 0);         // no block apart from the heap
  mallopt(M_TRIM_THRESHOLD, -1);  // no shrinking of the heap
  mallopt(M_ARENA_MAX, 1);        // blocks are few and large: one heap for all threads
  // The heap grows by a stretch that nobody touches yet, asks for large pages in it, and has it for later.
  constexpr std::size_t kStretch = std::size_t{4} << 30, kLargePage = std::size_t{2} << 20;
  char* const stretch = static_cast<char*>(std::malloc(kStretch));
  if (stretch == nullptr) return;
  const std::size_t skipped = kLargePage - reinterpret_cast<std::uintptr_t>(stretch) % kLargePage;
  madvise(stretch + skipped, kStretch - skipped, MADV_HUGEPAGE);
  std::free(stretch);
}

}  // namespace burnish::cli
