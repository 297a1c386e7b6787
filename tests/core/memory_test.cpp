// What methods take beside the mesh, as the kernel counts it: a program of its own, because the heap has to
// give back what it does not need.
#include <gtest/gtest.h>
#include <malloc.h>

#include <fstream>

#include "core/smooth/registry.h"
#include "tests/support/shapes.h"

namespace burnish::testing {
namespace {

/// Bytes in a line of /proc/self/status.
double status(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name)) return 1024 * std::stod(line.substr(name.size()));
  }
  return 0;
}

/// From now on the peak counts anew. False where there is no such file.
bool restart_peak() {
  std::ofstream file("/proc/self/clear_refs");
  return static_cast<bool>(file << "5" << std::flush);
}

/// The defaults, each choice of each parameter, and the largest radius, time step or lambda where there is
/// one.
std::vector<ParameterValues> variants(const Method& method) {
  std::vector<ParameterValues> all{*resolve_parameters(method, {})};
  for (const ParameterSpec& spec : method.parameters) {
    for (const std::string& choice : spec.choices) {
      all.push_back(all.front());
      all.back().values[spec.name] = choice;
    }
    if (spec.name != "radius" && spec.name != "time_step" && spec.name != "lambda") continue;
    all.push_back(all.front());
    all.back().values[spec.name] = spec.maximum;
  }
  for (ParameterValues& each : all) each.values["iterations"] = std::int64_t{2};
  return all;
}

/// Triangles that share no vertex.
Shape apart(const Shape& shape) {
  Shape result;
  for (const Triangle& t : shape.triangles) {
    const auto first = static_cast<Index>(result.positions.size());
    for (const Index v : t) {
      const double shift = 1e-3 * static_cast<double>(result.positions.size());
      result.positions.push_back(shape.positions[v] + Vec3d{0, 0, shift});
    }
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

/// The most that any of the variants took; of a mesh of several parts, which takes long, the defaults alone.
double peak_of(const Method& method, const Surface& surface) {
  double most = 0;
  auto tried = variants(method);
  if (surface.mesh.triangles.size() > WorkMemory::kPart) tried.resize(1);
  for (const ParameterValues& values : tried) {
    Surface smoothed = surface;
    if (!restart_peak()) return 0;
    const double before = status("VmRSS:");
    EXPECT_TRUE(method.run(smoothed, values, {.threads = 1}));
    most = std::max(most, status("VmHWM:") - before);
  }
  return most;
}

TEST(WorkMemory, IsWhatARunTakesAndAtMostTwiceThat) {
#if defined(__SANITIZE_ADDRESS__) || defined(_GLIBCXX_TSAN)  // see cmake/compiler.cmake
  GTEST_SKIP() << "sanitizers have a heap of their own";
#endif
  if (!restart_peak()) GTEST_SKIP() << "no peak to restart";
  mallopt(M_MMAP_THRESHOLD, 1 << 15);
  mallopt(M_TRIM_THRESHOLD, 0);
  const Shape closed = with_noise(grid(200), 0.1);
  const Surface surfaces[] = {surface_of(closed), surface_of(apart(with_noise(grid(100), 0.1))),
                              surface_of(with_noise(grid(600), 0.1))};
  for (const Method& method : methods()) {
    double share = 0;
    for (const Surface& surface : surfaces) {
      const bool large = surface.mesh.triangles.size() > WorkMemory::kPart;
      if (large && method.work_memory.per_triangle_of_part == 0) continue;
      const auto stated = static_cast<double>(
          method.work_memory.bytes(surface.mesh.positions.size(), surface.mesh.triangles.size()));
      share = std::max(share, peak_of(method, surface) / stated);
    }
    EXPECT_LE(share, 1) << method.name;
    EXPECT_GE(share, 0.5) << method.name;
  }
}

TEST(WorkMemory, OfAnUnknownMethodIsTheMost) {
  const WorkMemory most = work_memory_of("no such method");
  for (const Method& method : methods()) {
    EXPECT_GE(most.per_vertex, method.work_memory.per_vertex);
    EXPECT_GE(most.per_triangle, method.work_memory.per_triangle);
    EXPECT_EQ(work_memory_of(method.name).per_vertex, method.work_memory.per_vertex);
  }
  EXPECT_EQ(work_memory_of("").per_vertex, methods().front().work_memory.per_vertex);
}

}  // namespace
}  // namespace burnish::testing
