// Triangles that smoothing turned too far: their vertices go back part of the way that they came.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

/// What steps that sharpen a surface do to a triangle that lies across a crease: they lay it on one side or
/// the other, and now and then on the wrong one. Where they went too far, the vertices go back towards
/// `before`: half the way, and half of that, and in the end all of it. Too far is a triangle that turned away
/// from its predicted normal and is more than 60 degrees from it; and one that turned by more than 20 degrees
/// and has an edge that became sharper and is of more than 95 degrees. The same bits for any number of
/// threads. False when stopped.
bool take_back_turned(const Faces& faces, std::span<const SimdVec3> predicted,
                      std::span<const SimdVec3> before, std::span<SimdVec3> now);

/// The same towards the scan (the positions of faces.surface()) where a triangle that agreed with its
/// predicted normal there, within 90 degrees, no longer does. False when stopped.
bool take_back_flipped(const Faces& faces, std::span<const SimdVec3> predicted, std::span<SimdVec3> now);

}  // namespace burnish
