// What a job does beside smoothing: decode, prepare (of that, topology), measure, encode. One thread unless
// the name says two; Draco at its default speed. One case: pipeline_bench
// --benchmark_filter=prepare/triangles:69696
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <memory>

#include "core/io/codec.h"
#include "core/measure/error.h"
#include "core/measure/quality.h"
#include "core/smooth/laplacian.h"
#include "tests/bench/meshes.h"

namespace burnish::bench {
namespace {

/// A decoded OBJ file, its surface, and where five smoothing steps move its vertices.
struct Job {
  std::string text;
  std::unique_ptr<Document> document;
  Surface before, after;

  MovedPositions moved() const {
    return {document->positions(), before.weld, before.mesh.positions, after.mesh.positions,
            before.mesh.frame};
  }
};

const Job& job(benchmark::State& state) {
  const int triangles = static_cast<int>(state.range(0));
  static std::map<int, Job> made;
  const auto [at, added] = made.try_emplace(triangles);
  Job& result = at->second;
  if (added) {
    result.text = testing::to_obj(noisy_mesh(triangles));
    result.document = std::move(*decode(result.text, Format::Obj, {}, {}));
    result.before = noisy_surface(triangles);
    result.after = result.before;
    if (!smooth_laplacian(result.after, {}, {.iterations = 5}, {})) std::abort();
  }
  return result;
}

void count_triangles(benchmark::State& state, const Job& made) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(made.before.mesh.triangles.size()));
}

/// Runs `body`, which returns a Result, as the benchmark.
template <class Body>
void repeat(benchmark::State& state, const Job& made, Body&& body) {
  for (auto _ : state) {
    auto result = body();
    if (!result) return state.SkipWithError(result.error().message.c_str());
    benchmark::DoNotOptimize(result);
  }
  count_triangles(state, made);
}

void prepare(benchmark::State& state) {
  const Job& made = job(state);
  repeat(state, made,
         [&] { return prepare_surface(made.document->positions(), made.document->triangles(), {}); });
}

void topology(benchmark::State& state) {
  const Job& made = job(state);
  const Mesh& mesh = made.before.mesh;
  repeat(state, made, [&] { return build_topology(mesh.positions.size(), mesh.triangles, {}); });
}

/// Both parts of the report: the errors against the input and what became of the mesh.
void measure(benchmark::State& state) {
  const Job& made = job(state);
  const RunControl run{.threads = static_cast<unsigned>(state.range(1))};
  const auto &was = made.before.mesh.positions, &is = made.after.mesh.positions;
  repeat(state, made, [&]() -> Result<MeshChange> {
    const auto errors = measure_errors(made.before, is, made.before, was, true, run);
    if (!errors) return errors.error();
    return measure_change(made.before, was, is, run);
  });
}

void decode_obj(benchmark::State& state) {
  const Job& made = job(state);
  repeat(state, made, [&] { return decode(made.text, Format::Obj, {}, {}); });
}

void encode_obj(benchmark::State& state) {
  const Job& made = job(state);
  const MovedPositions moved = made.moved();
  repeat(state, made, [&] { return encode(*made.document, moved, {}, {}); });
}

OutputOptions draco_options(DracoMethod method, int bits) {
  return {.format = Format::Draco, .draco = {.method = method, .position_bits = bits}};
}

void encode_draco(benchmark::State& state, DracoMethod method, int bits) {
  const Job& made = job(state);
  const MovedPositions moved = made.moved();
  repeat(state, made, [&] { return encode(*made.document, moved, draco_options(method, bits), {}); });
}

void decode_draco(benchmark::State& state, DracoMethod method, int bits) {
  const Job& made = job(state);
  const auto encoded = encode(*made.document, made.moved(), draco_options(method, bits), {});
  if (!encoded) return state.SkipWithError(encoded.error().message.c_str());
  repeat(state, made, [&] { return decode(encoded->bytes, Format::Draco, {}, {}); });
}

void all_sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("triangles")->Unit(benchmark::kMillisecond);
  for (const int triangles : kSizes) benchmark->Arg(triangles);
}

void all_sizes_and_threads(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"triangles", "threads"})->Unit(benchmark::kMillisecond);
  benchmark->MeasureProcessCPUTime()->UseRealTime();
  for (const int triangles : kSizes) {
    for (const int threads : {1, 2}) benchmark->Args({triangles, threads});
  }
}

BENCHMARK(prepare)->Apply(all_sizes);
BENCHMARK(topology)->Apply(all_sizes);
BENCHMARK(measure)->Apply(all_sizes_and_threads);
BENCHMARK(decode_obj)->Apply(all_sizes);
BENCHMARK(encode_obj)->Apply(all_sizes);
BENCHMARK_CAPTURE(encode_draco, sequential_lossless, DracoMethod::Sequential, 0)->Apply(all_sizes);
BENCHMARK_CAPTURE(decode_draco, sequential_lossless, DracoMethod::Sequential, 0)->Apply(all_sizes);
BENCHMARK_CAPTURE(encode_draco, edgebreaker_14_bits, DracoMethod::Edgebreaker, 14)->Apply(all_sizes);
BENCHMARK_CAPTURE(decode_draco, edgebreaker_14_bits, DracoMethod::Edgebreaker, 14)->Apply(all_sizes);

}  // namespace
}  // namespace burnish::bench

BENCHMARK_MAIN();
