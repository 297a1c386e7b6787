// A preconditioner for the systems of sparse_system.h when weights are far above masses: then plain conjugate
// gradients need an iteration for every edge that a change has to travel, and this needs a few dozen for any
// mesh. Vertices are joined four by four along their greatest weights, those again, and so on; each level has
// the same kind of system, smoothed by a damped Jacobi step before and after its correction from the next.
//
// Correction that is constant on four vertices climbs from one four to the next in one stair, where it should
// in two: half the weight between fours makes up for that (D. Braess, Towards algebraic multigrid for
// elliptic problems of second order, Computing 55 (1995) 379-393).
//
// Same bits for any number of threads. Making the levels takes one thread, which asks for a stop.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/mesh/topology.h"
#include "core/run/parallel.h"

namespace burnish {

class Multigrid {
 public:
  /// Writes the rows of q = A p for the block of unknowns that starts at `begin`.
  using Product = std::function<void(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin)>;

  /// `weights` >= 0 are aligned with `neighbours`, `diagonal` is that of A and 0 where there is no unknown.
  /// All spans must outlive this. False when stopped.
  bool build(const IndexRows& neighbours, std::span<const float> weights, std::span<const float> diagonal,
             Product product, const RunControl& run);

  /// z, near the solution of A z = r, 0 where there is no unknown: linear in r, symmetric and positive
  /// definite. False when stopped.
  bool apply(std::span<const SimdVec3> r, std::span<SimdVec3> z, const RunControl& run);

 private:
  struct Graph {
    IndexRows neighbours = {};
    std::vector<float> weights = {};
    std::vector<float> hold = {};  ///< diagonal minus the weights
  };
  struct Level {
    std::size_t rows = 0;
    Product product = {};
    std::vector<float> step = {};    ///< of Jacobi: damping / diagonal, 0 where there is no unknown
    std::vector<Index> joined = {};  ///< row of the next level; kNone: none
    IndexRows members = {};          ///< rows of each row of the next level
    std::vector<SimdVec3> b = {}, x = {}, rest = {};  ///< the first level's b and x are the caller's
  };

  static bool join(const IndexRows& neighbours, std::span<const float> weights, std::vector<Index>& joined,
                   Index& count, const RunControl& run);
  static bool shrink(const IndexRows& neighbours, std::span<const float> weights, std::span<const float> hold,
                     std::span<const Index> joined, Index count, float share, Graph& to,
                     const RunControl& run);
  static bool coarsen(const IndexRows& neighbours, std::span<const float> weights,
                      std::span<const float> hold, Level& level, Graph& to, const RunControl& run);
  static Level level_of(const Graph& graph);
  static bool relax(Level& level, std::span<const SimdVec3> b, std::span<SimdVec3> x, const RunControl& run);
  bool cycle(std::size_t depth, std::span<const SimdVec3> b, std::span<SimdVec3> x, const RunControl& run);

  std::vector<std::unique_ptr<Graph>> graphs_;  ///< of all levels but the first
  std::vector<Level> levels_;
};

}  // namespace burnish
