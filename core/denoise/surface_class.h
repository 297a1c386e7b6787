// What kind of surface a mesh is: flat with edges, as machined parts are, or curved all over, as figures are.
#pragma once

#include <span>

#include "core/mesh/simd_vec3.h"
#include "core/mesh/surface.h"

namespace burnish {

/// Shares of flat edges up to which a surface is curved all over, and from which on it is mostly flat.
inline constexpr double kCurvedSurface = 0.67, kFlatSurface = 0.76;

/// Share, from 0 to 1, of the edges between two triangles across which these unit normals turn by less than
/// 3.4 degrees; 0 when there are none. Says nothing while the normals are noisy. Meaningless when stopped.
double share_of_flat_edges(const Topology& topology, std::span<const SimdVec3> normals,
                           const RunControl& run);

/// Share, from 0 to 1, of the surface's bending that is at edges sharper than 25 degrees: 0 of a free-form
/// surface, near 1 of a machined part, whose faces are flat or smooth. Bending is the sum over edges of their
/// length times 1 - cos(angle between the triangles). 0 when nothing bends. Meaningless when stopped.
double share_of_sharp_bending(const Surface& surface, const RunControl& run);

}  // namespace burnish
