// The feature-preserving, adaptive and anisotropic smoothing of the paper (Eq. 1 to 8), the service's
// default.
//
// Feature-preserving, Adaptive and Anisotropic Smoothing Algorithm for Triangular Mesh Models. Offsets after
// [5] Y. Ohtake, A. G. Belyaev, I. A. Bogaevski, Mesh regularization and adaptive smoothing, Computer-Aided
// Design 33
//     (2001) 789-800.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct AdaptiveParams {
  /// Eq. 1 as printed is a mean of unit normals and shorter than 1 at features; Unit makes it a unit vector.
  enum class Normals : std::uint8_t { Raw, Unit } normals = Normals::Raw;
  /// N(R) of Eq. 1: the triangles across the edges (the paper's 1-ring), or all that share a vertex (its
  /// 2-ring).
  enum class Neighbourhood : std::uint8_t { Edges, Vertices } neighbourhood = Neighbourhood::Edges;
  /// How the offsets of Eq. 2 are averaged over the triangles at a vertex. [5] weights by area; the plain
  /// mean reproduces the paper's tables best.
  enum class Offsets : std::uint8_t { Uniform, Area } offsets = Offsets::Uniform;
  /// Weights of the umbrella operator, Eq. 3.
  enum class Umbrella : std::uint8_t { Uniform, InverseLength } umbrella = Umbrella::Uniform;
  /// d = g(x): Eq. 6 exp(x), bounded by 1.5; Eq. 5 x and Eq. 7 1 - exp(-x/sigma^2), bounded by 1.
  enum class Coefficient : std::uint8_t {
    Exponential,
    Linear,
    Gaussian
  } coefficient = Coefficient::Exponential;
  double sigma = 0.2;  ///< of Eq. 7, 0.001 to 100
  /// x = |U|^2 / scale^2 (Eq. 4). In the mesh's unit; 0 = the mean edge length h of the mesh that was sent.
  /// The paper's x has the unit of a squared length, so its result would depend on the unit of the model.
  double scale = 0;
};

/// Eq. 8: v' = v + d V. Eq. 6 tends to d = 1, not 0, where the surface is flat; there V itself vanishes.
/// A free boundary uses the triangles and neighbours that there are. Moves surface.mesh.positions only.
/// Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> smooth_adaptive(Surface& surface, const AdaptiveParams& params,
                                      const IterationOptions& options, const RunControl& run);

/// The offset coefficient d = g(x) for x = |U|^2 / scale^2, bounded (Eq. 5 to 7).
double offset_coefficient(const AdaptiveParams& params, double x);

Method adaptive_method();

}  // namespace burnish
