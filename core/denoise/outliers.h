// The vertices that noise moved, where it moved few and left all others exactly where they belong.
#pragma once

#include <span>

#include "core/mesh/surface.h"
#include "core/run/buffer.h"
#include "core/run/parallel.h"

namespace burnish {

/// outlier[v] = 1 for movable vertices that a smoothing moved by more than what it moves those around by,
/// whom it moves because it is not perfect: 1.75 times the spread (median over .6745) of the moves within two
/// rings, and half of that of all. Vertices of a crowd (more than 64 neighbours) do not tell about each
/// other. Returns whether the moves look like that at all: their root mean square is more than 2.5 times
/// their spread; else no vertex is an outlier. Meaningless when stopped: ask run.stopped().
bool find_outliers(const Topology& topology, std::span<const std::uint8_t> movable,
                   std::span<const float> moves, std::span<std::uint8_t> outlier, const RunControl& run);

}  // namespace burnish
