// What smoothing did to the mesh as a whole.
#pragma once

#include <span>

#include "core/mesh/surface.h"

namespace burnish {

struct MeshChange {
  double rms_displacement = 0, max_displacement = 0;  ///< unit of the file, over vertices in triangles
  double area_percent = 0;    ///< 100 (after - before) / before; 0 when there was no area
  double volume_percent = 0;  ///< the same for the signed volume about the centre; 0 when there was none
  double smallest_angle_before = 0, smallest_angle_after = 0;  ///< degrees, over triangles
};

/// Errors: Cancelled, DeadlineExceeded.
Result<MeshChange> measure_change(const Surface& surface, std::span<const Vec3f> before,
                                  std::span<const Vec3f> after, const RunControl& run);

}  // namespace burnish
