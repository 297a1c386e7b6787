// Bilateral smoothing of vertices (Fleishman, Drori, Cohen-Or 2003): every vertex moves along its normal by
// the mean height of the vertices around it, where those near and of like height count most, so that what
// lies beyond an edge does not pull.
//
// S. Fleishman, I. Drori, D. Cohen-Or, Bilateral mesh denoising, SIGGRAPH 2003, 950-953.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct BilateralParams {
  double sigma_c = 1;  ///< closeness, in mean edge lengths of the input, 0.1 to 5
  /// Similarity of heights, in mean edge lengths of the input, up to 100; 0: the standard deviation of the
  /// heights around each vertex, in each iteration, at least 0.3 of their root mean square.
  double sigma_s = 0;
  /// Ring: the vertices that share an edge. Ball: all within 2 sigma_c (the paper) that edges within it lead
  /// to, the first kMostInBall of them.
  enum class Neighbourhood : std::uint8_t { Ring, Ball } neighbourhood = Neighbourhood::Ring;
};

inline constexpr std::size_t kMostInBall = 128;

/// The paper's few iterations, the default: each takes much noise, and from then on features.
inline constexpr std::uint32_t kBilateralIterations = 4;

/// v' = v + n sum w h / sum w, over the neighbours q of v: h = n . (q - v), w = exp(-|q - v|^2 / (2
/// sigma_c^2)) exp(-h^2 / (2 sigma_s^2)), n the area-weighted normal of the triangles at v. A vertex without
/// a normal stays. A free boundary uses the triangles and neighbours that there are. Moves
/// surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_bilateral(Surface& surface, const BilateralParams& params,
                                       const IterationOptions& options, const RunControl& run);

Method bilateral_method();

}  // namespace burnish
