// Every method of the registry: 20 iterations on one thread and on two. The counter is the time per vertex
// and iteration. One case: methods_bench --benchmark_filter=adaptive/triangles:69696/threads:1
#include <benchmark/benchmark.h>

#include "core/smooth/registry.h"
#include "tests/bench/meshes.h"

namespace burnish::bench {
namespace {

constexpr std::int64_t kIterations = 20;

void smooth(benchmark::State& state, const Method& method, int triangles, unsigned threads) {
  const Surface& start = noisy_surface(triangles);
  const auto values = resolve_parameters(method, {{"iterations", kIterations}});
  Surface surface = start;
  for (auto _ : state) {
    state.PauseTiming();  // every run starts from the noisy mesh
    surface.mesh.positions = start.mesh.positions;
    state.ResumeTiming();
    const auto outcome = method.run(surface, *values, {.threads = threads});
    if (!outcome || outcome->iterations != kIterations) {
      state.SkipWithError("the method did not finish its iterations");
      return;
    }
  }
  using benchmark::Counter;
  state.counters["per_vertex_and_iteration"] =
      Counter(static_cast<double>(surface.mesh.positions.size()) * kIterations,
              Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void register_all() {
  for (const Method& method : methods()) {
    for (const int triangles : kSizes) {
      for (const unsigned threads : {1U, 2U}) {
        const std::string name =
            method.name + "/triangles:" + std::to_string(triangles) + "/threads:" + std::to_string(threads);
        benchmark::RegisterBenchmark(name.c_str(), smooth, method, triangles, threads)
            ->Unit(benchmark::kMillisecond)
            ->MeasureProcessCPUTime()
            ->UseRealTime();
      }
    }
  }
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
  burnish::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
