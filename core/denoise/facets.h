// Where a surface is made of facets: flat, or nearly so, between edges that are much sharper than all else.
#pragma once

#include "core/smooth/normal_filter.h"

namespace burnish {

/// How much the surface around each face is that, from 0 to 1: the share of its bending that is at edges of
/// more than 25 degrees (see share_of_sharp_bending()), of 0.5 to 0.8, times the share of its edges that bend
/// by less than 8.6 degrees, of 0.6 to 0.75, both over some twelve rings. Folds and hair have sharp edges
/// too, but little between them that is flat. The faces must have been measured at the positions. False when
/// stopped.
bool weigh_facets(const Faces& faces, std::span<const SimdVec3> positions, std::span<float> weights);

/// Takes the noise that is left off the facets: `steps` times, the normals are filtered bilaterally where the
/// surface is made of facets, in part where it is so in part, and its vertices move to fit. Edges that the
/// filter sees as such come out as sharp as they are. Normals of the faces are afterwards those that the
/// vertices fit. Both buffers must hold the positions; the result is in both. False when stopped.
bool smooth_facets(Faces& faces, std::span<const std::uint8_t> movable, std::uint32_t steps,
                   Buffer<SimdVec3>& now, Buffer<SimdVec3>& next);

}  // namespace burnish
