// The global scheme of bilateral normal filtering (Zheng et al. 2011): one sparse system for all normals,
// over neighbours by edge, solved by conjugate gradients for the three coordinates at once.
#pragma once

#include <array>
#include <vector>

#include "core/smooth/bilateral_filter.h"
#include "core/smooth/conjugate_gradients.h"

namespace burnish {

/// Minimises (1 - lambda) sum A(i) |m(i) - sum_j w(i,j) m(j)|^2 + lambda sum A(i) |m(i) - n(i)|^2 over m,
/// with w(i,j) = K(i,j) A(j) / sum_j K(i,j) A(j) over the neighbours j of i, K the exp of the bilateral
/// exponent, held at the n that came. That is ((1 - lambda) (I - W)^T A (I - W) + lambda A) m = lambda A n. A
/// triangle whose neighbours all weigh next to nothing (K below 1e-12) has no first term.
class BilateralSystem {
 public:
  explicit BilateralSystem(const Faces& faces);

  /// Replaces the normals by the minimiser to 1e-5 (root mean square by area), made unit vectors. It takes
  /// about 100 iterations for lambda = 0.01, and no more than 1000. False when stopped.
  bool solve(Faces& faces, const BilateralWidths& widths, double lambda);

 private:
  bool weigh(const Faces& faces, const BilateralExponent& exponent, float lambda);
  bool gather_residuals(std::span<const SimdVec3> m, const Faces& faces);
  SimdVec3 smoothness_row(std::size_t i) const;
  SimdVec3 weighted_sum(std::span<const SimdVec3> of, const std::array<float, 3>& weights,
                        std::size_t i) const;

  std::span<const Triangle> neighbours_;
  std::vector<std::array<float, 3>> weights_;     // w(i,j), by the sides of i
  std::vector<std::array<float, 3>> transposed_;  // w(j,i) A(j) / A(i)
  std::vector<float> areas_, per_sum_;            // 1 / sum_j K(i,j) A(j); 0: no first term
  std::vector<float> inverse_diagonal_, inverse_mass_;
  std::vector<SimdVec3> residuals_;  // m(i) - sum_j w(i,j) m(j)
  std::vector<SimdVec3> right_side_, correction_;
  ConjugateGradients gradients_;
};

}  // namespace burnish
