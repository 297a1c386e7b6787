// How far a result is from a reference: Eq. 9 of the paper, and what goes with it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/mesh/surface.h"

namespace burnish {

/// Lengths in the unit of the file.
struct ErrorMeasures {
  /// Eq. 9: sqrt(sum over vertices P' of A(P') dist(P', M)^2 / (3 A(M'))), dist to the nearest point of the
  /// nearest triangle of the reference M, A(P') the area of the result's triangles at P'.
  double ev = 0;
  double ev_over_edge = 0;      ///< ev over the reference's mean edge length
  double ev_over_diagonal = 0;  ///< ev over the diagonal of the reference's bounding box
  double mean_distance = 0, rms_distance = 0, max_distance = 0;  ///< over the result's vertices, unweighted
  /// Angle between the normals of corresponding triangles; unset when the triangles do not correspond.
  std::optional<double> mean_normal_degrees, max_normal_degrees;
  std::optional<std::uint32_t> flipped_triangles;  ///< normals that turned by more than 90 degrees
};

/// Measures `positions` (of `surface`'s topology, in its frame) against `reference`, whose positions when it
/// was prepared are `reference_positions`. Same-connectivity measures are given when `corresponding` is set:
/// both come from files with the same triangles. Errors: Cancelled, DeadlineExceeded, OutOfMemory.
Result<ErrorMeasures> measure_errors(const Surface& surface, std::span<const Vec3f> positions,
                                     const Surface& reference, std::span<const Vec3f> reference_positions,
                                     bool corresponding, const RunControl& run);

/// Of each vertex of `surface` to the nearest point of the reference's triangles, in the unit of the file:
/// what measure_errors() sums up. 0 for vertices in no triangle. Errors: those of measure_errors().
Result<std::vector<double>> vertex_distances(const Surface& surface, std::span<const Vec3f> positions,
                                             const Surface& reference,
                                             std::span<const Vec3f> reference_positions, bool corresponding,
                                             const RunControl& run);

}  // namespace burnish
