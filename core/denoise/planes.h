// Where a surface is made of planes: what does not bend between creases, however obtuse those are.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

/// Settles such a surface on its planes, and where planes meet on their edges and corners. A plane is a set
/// of triangles, connected across edges that hardly bend, through which a quadric goes no better than a
/// plane: what it would gain is less than a fifth of how far the scan (the positions of faces.surface()) is
/// off, and it bends by less than 1.7 degrees (root mean squares). Triangles at its rim that turn away, as at
/// a fillet, are left out, up to 15% of its area. `normals` are those of the triangles at `now`, and become
/// those of the planes there; `steps` times the vertices move to fit. Both buffers must hold the positions;
/// the result is in both. One thread finds the planes. False when stopped.
bool settle_on_planes(Faces& faces, std::span<const std::uint8_t> movable, std::uint32_t steps,
                      Buffer<SimdVec3>& normals, Buffer<SimdVec3>& now, Buffer<SimdVec3>& next);

}  // namespace burnish
