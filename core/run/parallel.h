// Core's only threads: loops over fixed blocks in a oneTBB arena. Blocks have the same bounds whatever the
// number of threads, so sums over them come out the same to the last bit.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

#include "core/run/run_control.h"

namespace burnish {

/// Most items in a block: few enough that a stop is seen within a millisecond, enough to hide the dispatch.
inline constexpr std::size_t kBlockSize = 2048;

/// Items per block of a loop over so many: of equal size and even in number, from nine on a multiple of four,
/// so that two or four threads have as much to do. With 17 blocks of 2048 the slower of two threads has 9.
constexpr std::size_t block_size(std::size_t items) {
  const std::size_t blocks = (items + kBlockSize - 1) / kBlockSize;
  if (blocks < 2) return kBlockSize;
  const std::size_t multiple = blocks > 8 ? 4 : 2, rounded = (blocks + multiple - 1) / multiple * multiple;
  return (items + rounded - 1) / rounded;
}
/// Blocks of such a loop; the block that begins at `begin` is number begin / block_size(items).
constexpr std::size_t block_count(std::size_t items) {
  return (items + block_size(items) - 1) / block_size(items);
}

namespace detail {
using BlockFunction = void (*)(void* context, std::size_t block, std::size_t begin, std::size_t end);
bool run_blocks(std::size_t count, std::size_t block_size, const RunControl& run, BlockFunction function,
                void* context);
double sum_blocks(std::size_t count, const RunControl& run,
                  double (*function)(void*, std::size_t, std::size_t), void* context);
}  // namespace detail

/// Calls body(begin, end) for every block of [0, count), on run.threads threads. False when stopped half-way.
template <class Body>
bool parallel_for(std::size_t count, const RunControl& run, Body&& body) {
  using Plain = std::remove_reference_t<Body>;
  return detail::run_blocks(
      count, block_size(count), run,
      [](void* context, std::size_t, std::size_t begin, std::size_t end) {
        (*static_cast<Plain*>(context))(begin, end);
      },
      const_cast<void*>(static_cast<const void*>(std::addressof(body))));
}

/// Calls body(item) for every item of [0, count), as parallel_for does. False when stopped half-way.
template <class Body>
bool for_each(std::size_t count, const RunControl& run, Body&& body) {
  return parallel_for(count, run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// Calls body(task) for every task of [0, tasks), each large enough for a thread. Tasks ask run.stopped()
/// themselves. False when stopped.
template <class Body>
bool parallel_tasks(std::size_t tasks, const RunControl& run, Body&& body) {
  using Plain = std::remove_reference_t<Body>;
  return detail::run_blocks(
      tasks, 1, run,
      [](void* context, std::size_t task, std::size_t, std::size_t) {
        (*static_cast<Plain*>(context))(task);
      },
      const_cast<void*>(static_cast<const void*>(std::addressof(body))));
}

/// The threads that run.threads stands for, at least 1.
std::size_t thread_count(const RunControl& run);

/// Sum over all blocks of body(begin, end) in double, added in the order of the blocks. When stopped, the
/// value means nothing: ask run.stopped().
template <class Body>
double parallel_sum(std::size_t count, const RunControl& run, Body&& body) {
  using Plain = std::remove_reference_t<Body>;
  return detail::sum_blocks(
      count, run,
      [](void* context, std::size_t begin, std::size_t end) -> double {
        return (*static_cast<Plain*>(context))(begin, end);
      },
      const_cast<void*>(static_cast<const void*>(std::addressof(body))));
}

}  // namespace burnish
