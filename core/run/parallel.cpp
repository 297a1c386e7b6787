#include "core/run/parallel.h"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <vector>

namespace burnish::detail {

bool run_blocks(std::size_t count, const RunControl& run, BlockFunction function, void* context) {
  const std::size_t blocks = (count + kBlockSize - 1) / kBlockSize;
  const auto one = [&](std::size_t block) {
    function(context, block, block * kBlockSize, std::min(count, (block + 1) * kBlockSize));
  };
  if (run.threads == 1 || blocks < 2) {
    for (std::size_t block = 0; block < blocks; ++block) {
      if (run.stopped()) return false;
      one(block);
    }
    return !run.stopped();
  }
  std::atomic<bool> stopped = false;
  const int cores = tbb::info::default_concurrency();  // oneTBB warns on stderr about arenas with more
  tbb::task_arena arena(run.threads == 0 ? cores : std::min(cores, static_cast<int>(run.threads)));
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
      if (stopped.load(std::memory_order_relaxed)) return;
      if (run.stopped()) {
        stopped.store(true, std::memory_order_relaxed);
        return;
      }
      one(block);
    });
  });
  return !stopped.load() && !run.stopped();
}

double sum_blocks(std::size_t count, const RunControl& run,
                  double (*function)(void*, std::size_t, std::size_t), void* context) {
  struct Job {
    double (*function)(void*, std::size_t, std::size_t);
    void* context;
    std::vector<double> partial;
  } job{function, context, std::vector<double>((count + kBlockSize - 1) / kBlockSize)};
  run_blocks(
      count, run,
      [](void* p, std::size_t block, std::size_t begin, std::size_t end) {
        auto& j = *static_cast<Job*>(p);
        j.partial[block] = j.function(j.context, begin, end);
      },
      &job);
  double sum = 0;
  for (const double part : job.partial) sum += part;
  return sum;
}

}  // namespace burnish::detail
