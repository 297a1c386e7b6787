// Ours beside public libraries in one process: 20 iterations on a mesh and on its subdivisions, noise added.
//   compare MESH.obj [LEVELS=3]
// Prints nanoseconds per vertex and iteration (the least of a few runs) and the ratios to our laplacian; then
// two threads against one, and the share of a triad's memory bandwidth that laplacian reaches with them.
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <unordered_map>

#include "core/io/codec.h"
#include "core/run/parallel.h"
#include "core/smooth/registry.h"
#include "tests/bench/compare.h"
#include "tests/support/shapes.h"

namespace burnish::bench {
namespace {

using testing::Shape;

Shape load(const char* path) {
  const std::string text = testing::read_file(path);
  auto document = decode(text, Format::Obj, {}, {});
  if (!document) {
    std::fprintf(stderr, "%s: %s\n", path, document.error().message.c_str());
    std::exit(2);
  }
  return {{(*document)->positions().begin(), (*document)->positions().end()},
          {(*document)->triangles().begin(), (*document)->triangles().end()}};
}

/// Every triangle in four.
Shape subdivided(const Shape& shape) {
  Shape fine{shape.positions, {}};
  std::unordered_map<std::uint64_t, Index> middles;
  const auto middle = [&](Index a, Index b) {
    const auto [low, high] = std::minmax(a, b);
    const auto [at, added] =
        middles.try_emplace(std::uint64_t{low} << 32 | high, static_cast<Index>(fine.positions.size()));
    if (added) fine.positions.push_back((shape.positions[a] + shape.positions[b]) * 0.5);
    return at->second;
  };
  for (const auto& [a, b, c] : shape.triangles) {
    const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Triangle& t : {Triangle{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) {
      fine.triangles.push_back(t);
    }
  }
  return fine;
}

double least(int runs, const std::function<double()>& seconds) {
  double best = seconds();
  for (int i = 1; i < runs; ++i) best = std::min(best, seconds());
  return best;
}

double ours(const Surface& start, const char* name, unsigned threads) {
  const Method& method = **find_method(name);
  const auto values = resolve_parameters(method, {{"iterations", std::int64_t{kCompareIterations}}});
  Surface surface = start;
  const bool alone = threads == 1;
  const double begin = alone ? thread_seconds() : wall_seconds();
  if (!method.run(surface, *values, {.threads = threads})) std::abort();
  return (alone ? thread_seconds() : wall_seconds()) - begin;
}

/// Bytes a second that a = b + s * c moves on all cores, its three streams counted once each.
double triad_bandwidth() {
  constexpr std::size_t kFloats = std::size_t{1} << 26;
  std::vector<float> a(kFloats), b(kFloats, 1), c(kFloats, 2);
  const double seconds = least(5, [&] {
    const double begin = wall_seconds();
    parallel_for(kFloats, {.threads = 0}, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) a[i] = b[i] + 0.5F * c[i];
    });
    return wall_seconds() - begin;
  });
  return 3.0 * sizeof(float) * kFloats / seconds;
}

void compare(const Shape& shape) {
  Shape noisy = testing::with_noise(shape, 0);
  const Surface clean = testing::surface_of(shape);
  noisy = testing::with_noise(shape, 0.2 * clean.mean_edge * clean.mesh.frame.scale());
  const Surface surface = testing::surface_of(noisy);
  // The libraries get the file's order, as they would from a file; ours sorts, in a stage before this one.
  std::vector<Vec3f> given;
  for (const Vec3d& p : noisy.positions) given.push_back(surface.mesh.frame.to_local(p));
  const auto n = static_cast<double>(surface.mesh.positions.size());
  const auto nanoseconds = [&](double seconds) { return seconds * 1e9 / n / kCompareIterations; };
  const int runs = n > 1e6 ? 2 : n > 1e5 ? 4 : 15;

  std::printf("\n%zu vertices, %zu triangles, %d iterations, ns per vertex and iteration\n",
              surface.mesh.positions.size(), surface.mesh.triangles.size(), kCompareIterations);
  const double laplacian = least(runs, [&] { return ours(surface, "laplacian", 1); });
  const auto row = [&](const char* name, double seconds) {
    std::printf("  %-28s %8.2f   %6.2f x laplacian\n", name, nanoseconds(seconds), seconds / laplacian);
  };
  row("laplacian", laplacian);
  const double taubin = least(runs, [&] { return ours(surface, "taubin", 1); });
  row("taubin, both steps", taubin);
  const double adaptive = least(runs, [&] { return ours(surface, "adaptive", 1); });
  row("adaptive", adaptive);
  std::printf("  adaptive in all: %.2f ms\n", adaptive * 1e3);
  row("Eigen sparse product", least(runs, [&] { return eigen_product_seconds(given, noisy.triangles); }));
  const auto least_few = [&](auto seconds, int order) {
    return least(std::min(runs, 3), [&] { return seconds(given, noisy.triangles, order); });
  };
  row("OpenMesh Jacobi Laplace, C0", least_few(openmesh_seconds, 1));
  row("C1", least_few(openmesh_seconds, 2));
  row("C0, assertions on", least_few(openmesh_asserting_seconds, 1));

  const std::pair<const char*, double> alone[] = {
      {"laplacian", laplacian}, {"taubin", taubin}, {"adaptive", adaptive}};
  for (auto [name, one] : alone) {
    // By turns, for a second: the kernel takes a tenth of one to give a new thread a core of its own. A few
    // runs each, since the first finds positions in the other core's cache.
    double two = 1e9;
    const double until = wall_seconds() + 1;
    do {
      for (int run = 0; run < runs; ++run) two = std::min(two, ours(surface, name, 2));
      for (int run = 0; run < runs; ++run) {
        const double begin = wall_seconds();
        ours(surface, name, 1);
        one = std::min(one, wall_seconds() - begin);
      }
    } while (wall_seconds() < until);
    std::printf("  two threads, %-15s %8.2f   %6.2f times as fast as one\n", name, nanoseconds(two),
                one / two);
    if (std::string(name) != "laplacian") continue;
    // Must move: positions in and out, one index per neighbour.
    const double bytes =
        n * 2 * sizeof(Vec3f) + 4.0 * static_cast<double>(surface.topology.vertex_neighbours.items.size());
    const double rate = bytes * kCompareIterations / two;
    const double triad = triad_bandwidth();
    std::printf("  laplacian moves %.1f GB/s, a triad %.1f GB/s: %.0f%%\n", rate * 1e-9, triad * 1e-9,
                100 * rate / triad);
  }
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  // For all alike: a library's memory comes again for its next run, and the kernel's time for it is left out.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
  if (count < 2) {
    std::fprintf(stderr, "usage: compare MESH.obj [LEVELS=3]\n");
    return 2;
  }
  burnish::testing::Shape shape = burnish::bench::load(arguments[1]);
  const int levels = count > 2 ? std::atoi(arguments[2]) : 3;
  for (int level = 0; level <= levels; ++level) {
    if (level > 0) shape = burnish::bench::subdivided(shape);
    burnish::bench::compare(shape);
  }
}
