// Meshes whose triangles are of very different sizes, from meshes of one size: edges split until they are as
// short as asked for. The surface stays to the bit.
#pragma once

#include "tests/support/irregular.h"

namespace burnish::testing {

/// Splits edges that are longer than `size` at their middle, longest first, where that leaves no needles.
Shape refined(Shape shape, const std::function<double(const Vec3d&)>& size);

/// Where the small triangles are: along creases, as when surfaces were cut out of each other, or away from
/// them, as when each patch was meshed for itself. Spots of other sizes are strewn over both.
enum class Finest : std::uint8_t { AlongCreases, BetweenCreases };

/// With edges from a quarter of the mean to three or four times the mean; 2 to 5 times as many triangles.
Shape unevenly_refined(const Shape& shape, Finest finest, std::uint64_t seed);

}  // namespace burnish::testing
