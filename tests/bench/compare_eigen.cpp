#include <Eigen/SparseCore>
#include <cstdlib>
#include <vector>

#include "tests/bench/compare.h"

namespace burnish::bench {

double eigen_product_seconds(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const auto n = static_cast<Eigen::Index>(positions.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (const Triangle& t : triangles) {
    for (std::size_t side = 0; side < 3; ++side) {
      entries.emplace_back(t[side], t[(side + 1) % 3], 1.0);
      entries.emplace_back(t[(side + 1) % 3], t[side], 1.0);
    }
  }
  Rows step(n, n);
  step.setFromTriplets(entries.begin(), entries.end(), [](double, double) { return 1.0; });
  for (Eigen::Index row = 0; row < n; ++row) {  // v + (mean - v) / 2, the diagonal apart
    const auto valence = static_cast<double>(step.row(row).nonZeros());
    for (Rows::InnerIterator at(step, row); at; ++at) at.valueRef() = 0.5 / valence;
  }
  Rows diagonal(n, n);
  diagonal.setIdentity();
  step += 0.5 * diagonal;
  step.makeCompressed();

  Eigen::MatrixX3d x(n, 3), y(n, 3);
  for (Eigen::Index v = 0; v < n; ++v) {
    const Vec3f& p = positions[static_cast<std::size_t>(v)];
    x.row(v) << static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z);
  }
  const double start = thread_seconds();
  for (int i = 0; i < kCompareIterations; ++i) {
    y.noalias() = step * x;
    x.swap(y);
  }
  const double seconds = thread_seconds() - start;
  if (!x.allFinite()) std::abort();
  return seconds;
}

}  // namespace burnish::bench
