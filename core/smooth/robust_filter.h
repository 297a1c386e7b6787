// Two-stage filtering of face normals with a robust weight, Tukey's biweight, that gives neighbours turned
// farther than a threshold no weight at all.
//
// After S. K. Yadav, U. Reitebuch, K. Polthier, Robust and high fidelity mesh denoising, IEEE Transactions on
// Visualization and Computer Graphics 25 (2019) 2304-2310. The paper was not at hand: the formulas are ours.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

struct RobustWidths {
  /// Difference of unit normals from which on a neighbour does not count: of the normals as they are in the
  /// first stage, and of those that it gave in the second.
  double first_threshold = 2, second_threshold = 0.4;
  double sigma_c = 1.5;  ///< of the distance of centroids, in mean distances of those of adjacent triangles
};

/// Tukey's biweight rho(x) = (1 - x^2)^2 for x < 1, else 0; w(i, j; d, s) = A(j) exp(-|c(i) - c(j)|^2 / (2
/// sigma_c^2)) rho(d / s), over the neighbours j of i that the faces have. First stage, `steps` times:
/// m(i) = unit(sum w(i, j; |m(i) - m(j)|, first_threshold) m(j)), from m = n. Second stage, as often: n'(i) =
/// unit(sum w(i, j; |m(i) - m(j)|, second_threshold) n'(j)), from n' = n. Where a sum vanishes the normal
/// stays.
class RobustFilter {
 public:
  explicit RobustFilter(const Faces& faces) : input_(faces.size()), guide_(faces.size()) {}

  /// Both stages, with the areas and centroids that the faces have now. The same bits for any number of
  /// threads. False when stopped.
  bool filter(Faces& faces, const RobustWidths& widths, std::uint32_t steps);

 private:
  Buffer<SimdVec3> input_, guide_;
};

}  // namespace burnish
