// What the report takes beside what it reports on: both its parts (errors and change) for a mesh that
// `taubin` smoothed, and ten iterations of `adaptive`.
//   report_bench MESH.obj [REFERENCE.obj] [RUNS=40]
// Prints milliseconds of wall time, the least of the runs, which take turns, and their ratio, on one thread
// and on all. The reference is the mesh itself unless another with the same triangles is given.
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "core/io/codec.h"
#include "core/measure/error.h"
#include "core/measure/quality.h"
#include "core/smooth/registry.h"
#include "tests/support/shapes.h"

namespace burnish::bench {
namespace {

Surface load(const char* path) {
  const std::string text = testing::read_file(path);
  const Limits limits{.max_bytes = ~std::uint64_t{0}};
  auto document = decode(text, Format::Obj, limits, {});
  if (!document) {
    std::fprintf(stderr, "%s: %s\n", path, document.error().message.c_str());
    std::exit(2);
  }
  return std::move(*prepare_surface((*document)->positions(), (*document)->triangles(), {}));
}

void smooth(Surface& surface, const char* name, std::int64_t iterations, const RunControl& run) {
  const Method& method = **find_method(name);
  const auto values = resolve_parameters(method, {{"iterations", iterations}});
  if (!method.run(surface, *values, run)) std::abort();
}

template <class Body>
double milliseconds(Body&& body) {
  const auto begin = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void compare(const Surface& before, const Surface& reference, int runs) {
  Surface after = before;
  smooth(after, "taubin", 20, {});
  const auto& is = after.mesh.positions;
  std::printf("%zu triangles\n", before.mesh.triangles.size());
  for (const unsigned threads : {1U, 0U}) {
    const RunControl run{.threads = threads};
    double errors = 1e9, change = 1e9, adaptive = 1e9;
    for (int i = 0; i < runs; ++i) {
      Surface surface = before;
      adaptive = std::min(adaptive, milliseconds([&] { smooth(surface, "adaptive", 10, run); }));
      errors = std::min(errors, milliseconds([&] {
                          if (!measure_errors(before, is, reference, reference.mesh.positions, true, run))
                            std::abort();
                        }));
      change = std::min(change, milliseconds([&] {
                          if (!measure_change(before, before.mesh.positions, is, run)) std::abort();
                        }));
    }
    std::printf("%s: errors %.2f ms, change %.2f ms, ten iterations of adaptive %.2f ms: ratio %.2f\n",
                threads == 1 ? "one thread" : "all threads", errors, change, adaptive,
                (errors + change) / adaptive);
  }
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: report_bench MESH.obj [REFERENCE.obj] [RUNS=40]\n");
    return 2;
  }
  // For both: memory that was given back is used again.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
  const auto mesh = burnish::bench::load(arguments[1]);
  const auto reference = burnish::bench::load(arguments[count > 2 ? 2 : 1]);
  burnish::bench::compare(mesh, reference, count > 3 ? std::atoi(arguments[3]) : 40);
}
