// The linear system of the implicit methods: every vertex is held by its mass M where it was, p, and drawn to
// its neighbours by weights W,
//     M_v (x_v - p_v) + sum over neighbours w of W_vw (x_v - x_w) = 0   for every movable v,
// the minimum of sum M_v |x_v - p_v|^2 + sum over edges W_vw |x_v - x_w|^2. Other vertices stay: they are in
// the sums of their neighbours, and the matrix over the movable ones is symmetric and positive definite. Each
// x_v is a weighted mean of old positions, so nothing leaves their convex hull.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/smooth/conjugate_gradients.h"
#include "core/smooth/iteration.h"
#include "core/smooth/multigrid.h"
#include "core/smooth/sparse_cholesky.h"
#include "core/smooth/valence_order.h"

namespace burnish {

/// Rows are scaled by the squared mean edge length h^2 of the input: masses are areas over h^2. A mass is at
/// least this, so that slivers and what has shrunk to a point leave the system solvable.
inline constexpr float kLeastMass = 1e-4F;

struct SolverOptions {
  enum class Kind : std::uint8_t {
    Auto,  ///< what is expected to be faster for this mesh and these weights
    ConjugateGradients,
    Cholesky,
  } kind = Kind::Auto;
  /// Bound on the root mean square distance to the exact solution, weighted by mass, in mean edge lengths of
  /// the input, 1e-6 to 0.1. Conjugate gradients stop when their residual proves it; by then they are usually
  /// a hundred times nearer. Single precision sets a floor: 3e-8 where W is about M, 2e-5 where it is a
  /// thousand times that. Cholesky does not need it.
  double tolerance = 1e-4;
  std::uint32_t most_iterations = 5000;  ///< of conjugate gradients; enough for any mesh that was seen
};

/// A factorisation cannot be stopped half-way: it is only tried where each of its two parts takes less than
/// about 25 ms, the order of so many vertices and so many multiplications. A scan of 12 000 vertices is
/// within that, a sphere of 10 000 is not.
inline constexpr std::size_t kMostCholeskyVertices = 20'000;
inline constexpr double kMostCholeskyOperations = 5e7;

/// A method's own parameters, `solver` and `tolerance`, and those of every iterative method: five iterations
/// by default, since each does what a dozen explicit ones do.
std::vector<ParameterSpec> with_solver_parameters(std::vector<ParameterSpec> own);
SolverOptions solver_options(const ParameterValues& values);

/// Memory for the solution, made once per run; solve() allocates only in Cholesky's factorisation.
class SparseSystem {
 public:
  SparseSystem(const Surface& surface, std::span<const std::uint8_t> movable, const SolverOptions& options,
               const RunControl& run);

  /// row(v, weights) fills W_vw >= 0 for vertex_neighbours[v], symmetric between movable vertices, and
  /// returns M_v > 0; by several threads at once. What is solved for is the way from `from`, where the
  /// vertices are, since single precision holds a short way better than a place. False when stopped.
  template <class Row>
  bool solve(std::span<const SimdVec3> from, Row&& row) {
    const auto sums = sums_.over(movable_.size(), run_, [&](std::size_t begin, std::size_t end) {
      std::array<double, 2> block{};
      for (std::size_t v = begin; v < end; ++v) {
        if (movable_[v] == 0) continue;
        const auto weights = std::span(weights_).subspan(offsets_[v], offsets_[v + 1] - offsets_[v]);
        mass_[v] = row(v, weights);
        finish_row(v, weights, from);
        block[0] += static_cast<double>(mass_[v]);
        block[1] += static_cast<double>(diagonal_[v]);
      }
      return block;
    });
    return sums && solve_assembled((*sums)[0], (*sums)[1]);
  }

  /// Way of every vertex from where it was to the solution; 0 for those that do not move.
  std::span<const SimdVec3> way() const { return way_; }

  /// Adds what went otherwise than asked.
  void warn(std::vector<Warning>& warnings) const;

 private:
  void finish_row(std::size_t v, std::span<const float> weights, std::span<const SimdVec3> from);
  bool solve_assembled(double total_mass, double total_diagonal);
  bool prefers_cholesky(double diagonal_over_mass);
  double expected_iterations(double diagonal_over_mass) const;
  std::optional<ConjugateGradientsReport> solve_by_gradients(double diagonal_over_mass, double enough);
  bool may_factorise();
  bool solve_by_cholesky();
  void multiply(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin) const;

  const Surface& surface_;
  std::span<const Index> offsets_;
  std::span<const std::uint8_t> movable_;
  SolverOptions options_;
  const RunControl& run_;
  std::size_t unknowns_;
  ValenceOrder order_;
  std::vector<float> weights_, mass_, diagonal_, inverse_diagonal_, inverse_mass_;
  std::vector<SimdVec3> pull_, way_;
  BlockSums sums_;
  ConjugateGradients gradients_;
  std::optional<Multigrid> multigrid_;
  std::optional<SparseCholesky> cholesky_;
  std::uint32_t gradients_used_ = 0, not_converged_ = 0;  ///< solves
};

/// The loop of a method whose moves are the solutions: `prepare` calls the system's solve().
Result<SmoothOutcome> iterate_system(Surface& surface, const Constraints& constraints,
                                     const IterationOptions& options, const RunControl& run,
                                     const SparseSystem& system,
                                     std::function<bool(std::span<const SimdVec3> from)> prepare);

}  // namespace burnish
