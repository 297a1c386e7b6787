#include "core/run/parallel.h"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#if defined(BURNISH_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <vector>

namespace burnish {

std::size_t thread_count(const RunControl& run) {
  const int cores = tbb::info::default_concurrency();  // oneTBB warns on stderr about arenas with more
  return static_cast<std::size_t>(run.threads == 0 ? cores : std::min(cores, static_cast<int>(run.threads)));
}

namespace {

/// What oneTBB guarantees, that a loop's blocks start after what was before it and end before what follows,
/// told to the thread sanitizer, for which neither the library nor this file is built (see CMakeLists.txt).
class Order {
 public:
#if defined(BURNISH_THREAD_SANITIZER)
  void release() { __tsan_release(this); }
  void acquire() { __tsan_acquire(this); }
#else
  void release() {}
  void acquire() {}
#endif
};

/// Blocks that nobody has taken yet of those that a thread is to do.
class Share {
 public:
  void give(std::size_t first, std::size_t end) { rest_ = std::uint64_t{end} << 32 | first; }
  /// Of the owner, from the front.
  std::optional<std::size_t> take_first() {
    std::uint64_t rest = rest_;
    do {
      if (first(rest) == end(rest)) return {};
    } while (!rest_.compare_exchange_weak(rest, rest + 1));
    return first(rest);
  }
  /// Of another, from the back.
  std::optional<std::size_t> take_last() {
    std::uint64_t rest = rest_;
    do {
      if (first(rest) == end(rest)) return {};
    } while (!rest_.compare_exchange_weak(rest, rest - (std::uint64_t{1} << 32)));
    return end(rest) - 1;
  }

 private:
  static std::size_t first(std::uint64_t rest) { return rest & 0xffff'ffffU; }
  static std::size_t end(std::uint64_t rest) { return rest >> 32; }

  alignas(64) std::atomic<std::uint64_t> rest_;  // a line of its own: owners do not wait for each other
};

/// One arena per calling thread and number of threads: its workers wait in it for the next loop for a while,
/// where those of a new arena would have to be called together again. With 80 us of work for one thread in a
/// loop, two take 47 us this way, and 90 with a new arena each time.
tbb::task_arena& arena_of(std::size_t threads) {
  thread_local std::map<std::size_t, tbb::task_arena> arenas;
  return arenas.try_emplace(threads, static_cast<int>(threads)).first->second;
}

}  // namespace

namespace detail {

bool run_blocks(std::size_t count, std::size_t block_size, const RunControl& run, BlockFunction function,
                void* context) {
  const std::size_t blocks = (count + block_size - 1) / block_size;
  const auto one = [&](std::size_t block) {
    function(context, block, block * block_size, std::min(count, (block + 1) * block_size));
  };
  if (run.threads == 1 || blocks < 2) {
    for (std::size_t block = 0; block < blocks; ++block) {
      if (run.stopped()) return false;
      one(block);
    }
    return !run.stopped();
  }
  // Each thread has a share of its own, the same in every loop over as many blocks: what an iteration wrote
  // is still in the cache of the core that reads it in the next. Who is done helps the others.
  const std::size_t threads = thread_count(run);
  std::vector<Share> shares(threads);
  for (std::size_t t = 0; t < threads; ++t) shares[t].give(t * blocks / threads, (t + 1) * blocks / threads);
  std::atomic<bool> stopped = false;
  Order started, ended;
  started.release();
  arena_of(threads).execute([&] {
    tbb::parallel_for(
        std::size_t{0}, threads,
        [&](std::size_t) {
          started.acquire();
          const auto goes_on = [&] {
            if (run.stopped()) stopped.store(true, std::memory_order_relaxed);
            return !stopped.load(std::memory_order_relaxed);
          };
          const auto own = static_cast<std::size_t>(tbb::this_task_arena::current_thread_index());
          while (goes_on()) {
            std::optional<std::size_t> block = shares[own].take_first();
            for (std::size_t k = 1; k < threads && !block; ++k)
              block = shares[(own + k) % threads].take_last();
            if (!block) break;
            one(*block);
          }
          ended.release();
        },
        tbb::simple_partitioner());
  });
  ended.acquire();
  return !stopped.load() && !run.stopped();
}

double sum_blocks(std::size_t count, const RunControl& run,
                  double (*function)(void*, std::size_t, std::size_t), void* context) {
  struct Job {
    double (*function)(void*, std::size_t, std::size_t);
    void* context;
    std::vector<double> partial;
  } job{function, context, std::vector<double>(block_count(count))};
  run_blocks(
      count, block_size(count), run,
      [](void* p, std::size_t block, std::size_t begin, std::size_t end) {
        auto& j = *static_cast<Job*>(p);
        j.partial[block] = j.function(j.context, begin, end);
      },
      &job);
  double sum = 0;
  for (const double part : job.partial) sum += part;
  return sum;
}

}  // namespace detail
}  // namespace burnish
