// Direct solution of a sparse system over a mesh's vertices: LDL^T with a fill-reducing order (approximate
// minimum degree), in double precision, by Eigen. Its time does not depend on how hard the system is, but
// grows faster than the mesh, takes one thread, and can not be stopped half-way.
#pragma once

#include <memory>
#include <span>

#include "core/mesh/simd_vec3.h"
#include "core/mesh/topology.h"

namespace burnish {

class SparseCholesky {
 public:
  /// Orders the vertices with unknown[v] != 0, and finds where the factor has entries: once per
  /// mesh. At least one must be unknown.
  SparseCholesky(const Topology& topology, std::span<const std::uint8_t> unknown);
  ~SparseCholesky();

  /// Multiplications of a factorisation; its entries, of 12 bytes, are far fewer. Known before solve() makes
  /// it.
  double operations() const;

  /// Solves M_v x_v + sum over neighbours w of W_vw (x_v - x_w) = b_v for the unknown v, x_w = 0 for the
  /// others, which are not written. `weights` W >= 0 are aligned with topology.vertex_neighbours and
  /// symmetric between unknowns, `mass` M > 0. False when rounding leaves no positive pivot.
  bool solve(std::span<const float> weights, std::span<const float> mass, std::span<const SimdVec3> b,
             std::span<SimdVec3> x);

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace burnish
