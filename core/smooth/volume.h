// Keeping the volume that smoothing takes: what each component lost is given back by one offset along its
// vertex normals, the smallest displacement that does so.
#pragma once

#include <span>

#include "core/smooth/constraints.h"
#include "core/smooth/registry.h"

namespace burnish {

/// Moves `positions`, the smoothed ones, so that every component encloses what it did in `surface`. Holes are
/// closed by a fan around the mean of the component's boundary vertices, so nothing depends on where the mesh
/// lies. Only vertices that may move do, and only where they may; a component whose volume cannot be restored
/// so is counted by the warning "volume_not_kept". False when stopped.
bool restore_volume(const Surface& surface, const Constraints& constraints, std::span<SimdVec3> positions,
                    const RunControl& run, std::vector<Warning>& warnings);

}  // namespace burnish
