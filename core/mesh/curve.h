// The order in which a space-filling curve visits points: what is near in space comes near in memory.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/run/run_control.h"

namespace burnish {

/// The points' indices along a Morton curve through their bounding box, of 1024 cells along its longest side;
/// where many share a cell, along a curve through that cell again, so that a point far from all others does
/// no harm. Points at one place keep their order. O(n), for coordinates up to 1e19 in magnitude. When
/// stopped, any order.
std::vector<Index> curve_order(std::span<const Vec3f> points, const RunControl& run);

}  // namespace burnish
