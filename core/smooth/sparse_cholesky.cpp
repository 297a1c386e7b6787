#include "core/smooth/sparse_cholesky.h"

#include <Eigen/SparseCholesky>

namespace burnish {

namespace {

using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// Eigen's, which keeps the size of its factor to itself.
struct Ldlt : Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>> {
  double operations() const {
    double sum = 0;
    for (const int entries : m_nonZerosPerCol) sum += static_cast<double>(entries) * entries;
    return sum;
  }
};

}  // namespace

struct SparseCholesky::Factor {
  const Topology& topology;
  std::vector<Index> vertices;  ///< of the unknowns, ascending
  std::vector<int> unknowns;    ///< of the vertices, -1: none
  Matrix matrix;                ///< the lower triangle
  Eigen::MatrixX3d right;
  Ldlt ldlt;

  Factor(const Topology& t, std::span<const std::uint8_t> unknown)
      : topology(t), unknowns(unknown.size(), -1) {
    for (Index v = 0; v < unknown.size(); ++v) {
      if (unknown[v] == 0) continue;
      unknowns[v] = static_cast<int>(vertices.size());
      vertices.push_back(v);
    }
    const auto n = static_cast<Eigen::Index>(vertices.size());
    matrix.resize(n, n);
    matrix.reserve(n + static_cast<Eigen::Index>(topology.vertex_neighbours.items.size() / 2));
    // Neighbours ascend, so the columns come out sorted.
    for (int column = 0; column < n; ++column) {
      matrix.startVec(column);
      matrix.insertBack(column, column) = 1;
      for (const Index w : topology.vertex_neighbours[vertices[static_cast<std::size_t>(column)]]) {
        if (unknowns[w] > column) matrix.insertBack(unknowns[w], column) = 1;
      }
    }
    matrix.finalize();
    right.resize(n, 3);
    ldlt.analyzePattern(matrix);
  }

  void fill(std::span<const float> weights, std::span<const float> mass) {
    double* value = matrix.valuePtr();
    for (std::size_t column = 0; column < vertices.size(); ++column) {
      const Index v = vertices[column];
      double& diagonal = *value++;
      diagonal = static_cast<double>(mass[v]);
      const auto neighbours = topology.vertex_neighbours[v];
      const float* const row = weights.data() + topology.vertex_neighbours.offsets[v];
      for (std::size_t k = 0; k < neighbours.size(); ++k) {
        const auto weight = static_cast<double>(row[k]);
        diagonal += weight;
        if (unknowns[neighbours[k]] > static_cast<int>(column)) *value++ = -weight;
      }
    }
  }
};

SparseCholesky::SparseCholesky(const Topology& topology, std::span<const std::uint8_t> unknown)
    : factor_(std::make_unique<Factor>(topology, unknown)) {}
SparseCholesky::~SparseCholesky() = default;

double SparseCholesky::operations() const { return factor_->ldlt.operations(); }

bool SparseCholesky::solve(std::span<const float> weights, std::span<const float> mass,
                           std::span<const SimdVec3> b, std::span<SimdVec3> x) {
  Factor& f = *factor_;
  f.fill(weights, mass);
  f.ldlt.factorize(f.matrix);
  if (f.ldlt.info() != Eigen::Success || !(f.ldlt.vectorD().minCoeff() > 0)) return false;
  for (std::size_t i = 0; i < f.vertices.size(); ++i) {
    const SimdVec3& row = b[f.vertices[i]];
    f.right.row(static_cast<Eigen::Index>(i)) << static_cast<double>(row.x()), static_cast<double>(row.y()),
        static_cast<double>(row.z());
  }
  f.right = f.ldlt.solve(f.right);
  for (std::size_t i = 0; i < f.vertices.size(); ++i) {
    const auto row = f.right.row(static_cast<Eigen::Index>(i));
    x[f.vertices[i]] =
        SimdVec3(static_cast<float>(row[0]), static_cast<float>(row[1]), static_cast<float>(row[2]));
  }
  return true;
}

}  // namespace burnish
