// Conjugate gradients for A x = b, A symmetric and positive definite, where every unknown is a vector: its
// three coordinates share one Krylov space, so that each entry of A is read once and the result turns with
// the mesh. Preconditioned by the diagonal, or by what the caller brings.
//
// Vectors are single precision, because positions are; sums are double, in fixed order, so any number of
// threads gives the same bits. Rounding adds about 3e-8 of |x| times the square root of the condition number.
// Write the system for the CORRECTION of what is known (b the residual, x from 0): then |x| is small.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/run/parallel.h"

namespace burnish {

/// A pair of sums over fixed blocks, added in their order.
class BlockSums {
 public:
  explicit BlockSums(std::size_t rows) : of_block_(block_count(rows)) {}

  /// body(begin, end) returns the two sums of its block. Unset when stopped.
  template <class Body>
  std::optional<std::array<double, 2>> over(std::size_t rows, const RunControl& run, Body&& body) {
    if (!parallel_for(rows, run, [&](std::size_t begin, std::size_t end) {
          of_block_[begin / block_size(rows)] = body(begin, end);
        })) {
      return std::nullopt;
    }
    std::array<double, 2> total{};
    for (const auto& block : of_block_) total[0] += block[0], total[1] += block[1];
    return total;
  }

 private:
  std::vector<std::array<double, 2>> of_block_;
};

/// What is known about the matrix beside its products. A row whose inverse diagonal is 0 is no unknown: its x
/// stays 0 (in a system of corrections: it keeps its value).
struct SystemDiagonals {
  std::span<const float> inverse;  ///< 1 / A's diagonal
  /// 1 / M for a diagonal matrix M such that A - M is positive semidefinite, the mass: then the error of x
  /// in M's norm is at most the residual in that of its inverse, which is when to stop.
  std::span<const float> inverse_mass;
};

struct ConjugateGradientsReport {
  std::uint32_t iterations = 0;
  double residual = 0;     ///< sum of |b - A x|^2 / M, as the recurrence has it
  bool converged = false;  ///< residual <= enough
};

/// The work arrays; solve() allocates one more for a preconditioner, once.
class ConjugateGradients {
 public:
  explicit ConjugateGradients(std::size_t rows)
      : residual_(rows), direction_(rows), product_(rows), sums_(rows) {}

  /// Starts from x = 0 and overwrites `x`. apply(p, q, begin, end) writes those rows of q = A p, by several
  /// threads at once, and leaves out those that are no unknowns; apply.gather(p), where there is one, comes
  /// before, once for all rows, and is false when stopped; apply.precondition(r, z), where there is one,
  /// writes z = B r, B symmetric and positive definite and near the inverse of A. Ends when the residual is
  /// at most `enough`, after `most_iterations`, or when rounding leaves no direction. Unset when stopped.
  template <class Apply>
  std::optional<ConjugateGradientsReport> solve(Apply&& apply, const SystemDiagonals& diagonals,
                                                std::span<const SimdVec3> b, std::span<SimdVec3> x,
                                                double enough, std::uint32_t most_iterations,
                                                const RunControl& run) {
    const std::size_t rows = residual_.size();
    SimdVec3 *const r = residual_.data(), *const p = direction_.data(), *const q = product_.data();
    const float* const inverse = diagonals.inverse.data();
    const float* const inverse_mass = diagonals.inverse_mass.data();

    auto sums = sums_.over(rows, run, [&](std::size_t begin, std::size_t end) {
      std::array<double, 2> block{};
      for (std::size_t v = begin; v < end; ++v) {
        x[v] = q[v] = SimdVec3{};
        r[v] = b[v];
        p[v] = r[v] * inverse[v];
        const double square = static_cast<double>(dot(r[v], r[v]));
        block[0] += square * static_cast<double>(inverse[v]);
        block[1] += square * static_cast<double>(inverse_mass[v]);
      }
      return block;
    });

    constexpr bool kPreconditioned = requires {
      apply.precondition(std::span<const SimdVec3>(residual_), std::span(preconditioned_));
    };
    // Replaces r^T D^-1 r by r^T B r. False when stopped.
    const auto precondition = [&] {
      if constexpr (kPreconditioned) {
        const std::span<SimdVec3> z = preconditioned_;
        if (!sums || !apply.precondition(std::span<const SimdVec3>(residual_), z)) return false;
        const auto energies = sums_.over(rows, run, [&](std::size_t begin, std::size_t end) {
          double block = 0;
          for (std::size_t v = begin; v < end; ++v) block += static_cast<double>(dot(r[v], z[v]));
          return std::array{block, 0.0};
        });
        if (!energies) return false;
        (*sums)[0] = (*energies)[0];
      }
      return true;
    };
    if constexpr (kPreconditioned) {
      preconditioned_.resize(rows);
      if (!precondition()) return std::nullopt;
      std::ranges::copy(preconditioned_, p);
    }

    ConjugateGradientsReport report;
    for (;; ++report.iterations) {
      if (!sums) return std::nullopt;
      const double energy = (*sums)[0];  // r^T D^-1 r
      report.residual = (*sums)[1];
      report.converged = report.residual <= enough;
      if (report.converged || report.iterations == most_iterations) return report;

      if constexpr (requires { apply.gather(std::span<const SimdVec3>(direction_)); }) {
        if (!apply.gather(std::span<const SimdVec3>(direction_))) return std::nullopt;
      }
      const auto curvature = sums_.over(rows, run, [&](std::size_t begin, std::size_t end) {
        apply(std::span<const SimdVec3>(direction_), std::span(product_), begin, end);
        double block = 0;
        for (std::size_t v = begin; v < end; ++v) block += static_cast<double>(dot(p[v], q[v]));
        return std::array{block, 0.0};
      });
      if (!curvature) return std::nullopt;
      if (!((*curvature)[0] > 0)) return report;
      const float step = static_cast<float>(energy / (*curvature)[0]);

      sums = sums_.over(rows, run, [&](std::size_t begin, std::size_t end) {
        std::array<double, 2> block{};
        for (std::size_t v = begin; v < end; ++v) {
          x[v] += p[v] * step;
          r[v] -= q[v] * step;
          const double square = static_cast<double>(dot(r[v], r[v]));
          block[0] += square * static_cast<double>(inverse[v]);
          block[1] += square * static_cast<double>(inverse_mass[v]);
        }
        return block;
      });
      if (!sums || !precondition()) return std::nullopt;
      const float share = static_cast<float>((*sums)[0] / energy);
      const bool turned = parallel_for(rows, run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          if constexpr (kPreconditioned) {
            p[v] = preconditioned_[v] + p[v] * share;
          } else {
            p[v] = r[v] * inverse[v] + p[v] * share;
          }
        }
      });
      if (!turned) return std::nullopt;
    }
  }

 private:
  std::vector<SimdVec3> residual_, direction_, product_, preconditioned_;
  BlockSums sums_;
};

}  // namespace burnish
