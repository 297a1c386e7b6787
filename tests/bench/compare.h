// Public libraries that smooth, behind one signature: 20 steps from `positions`, seconds of this thread's
// time. Each is in a file of its own, because their headers take long to compile.
#pragma once

#include <chrono>
#include <ctime>
#include <span>

#include "core/mesh/mesh.h"

namespace burnish::bench {

inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline constexpr int kCompareIterations = 20;

/// The libigl way: a row-normalised Eigen::SparseMatrix<double, RowMajor> times an n x 3 matrix of double.
double eigen_product_seconds(std::span<const Vec3f> positions, std::span<const Triangle> triangles);
/// OpenMesh::Smoother::JacobiLaplaceSmootherT, tangential and normal; of order 1 (C0), the step of our
/// laplacian, or 2 (C1).
double openmesh_seconds(std::span<const Vec3f> positions, std::span<const Triangle> triangles, int order);
/// The same with OpenMesh's assertions, as programs that do not define NDEBUG get it. In a library that hides
/// its symbols, or the linker would take one of the two for both.
[[gnu::visibility("default")]] double openmesh_asserting_seconds(std::span<const Vec3f> positions,
                                                                 std::span<const Triangle> triangles,
                                                                 int order);

}  // namespace burnish::bench
