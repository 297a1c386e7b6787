// Smoothing as the design of a filter (Taubin, Zhang, Golub 1996): a polynomial of the umbrella operator that
// lets low frequencies pass and stops high ones, sharper than taubin for the same number of steps. VTK calls
// it windowed sinc.
//
// G. Taubin, T. Zhang, G. Golub, Optimal surface smoothing as filter design, ECCV 1996, 283-292.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct WindowedSincParams {
  /// Frequencies k of -U up to this pass, 0 to 2. 0.1 keeps what is longer than some 20 mean edge lengths.
  double pass_band = 0.1;
  enum class Window : std::uint8_t { Hamming, Blackman, Hanning, Rectangle } window = Window::Hamming;
};

/// The largest degree; beyond it the polynomials only gather rounding.
inline constexpr std::uint32_t kMostSincDegree = 1000;

/// v' = f(-U) v, f(k) = sum over n = 0 to N of c_n T_n(1 - k/2), T_n the Chebyshev polynomials, N the number
/// of iterations (at most kMostSincDegree), c_0 = w_0 phi/pi, c_n = w_n 2 sin(n phi)/(n pi), divided by their
/// sum, so that f(0) = 1: nothing shifts or scales. w_n is the window, in a = n pi/(N + 1): Hamming .54 + .46
/// cos a, Blackman .42 + .5 cos a + .08 cos 2a, Hanning .5 + .5 cos a, rectangle 1. cos phi_0 = 1 -
/// pass_band/2, and phi >= phi_0 is the least that makes the pass band pass, sum c_n T_n(cos phi_0) = 1
/// before the division; a degree too low for that keeps everything.
///
/// Vertices that stay have U = 0; free boundary vertices as in smooth_laplacian(). The constraints hold for
/// the result, not for each T_n. Moves surface.mesh.positions only. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_windowed_sinc(Surface& surface, const WindowedSincParams& params,
                                           const IterationOptions& options, const RunControl& run);

Method windowed_sinc_method();

}  // namespace burnish
