// The step of `adaptive` for many vertices at once, with the widest vectors that the processor has. Whatever
// their width, every number comes out of the same operations in the same order: the same bits.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/smooth/valence_order.h"

namespace burnish::adaptive_kernels {

struct Kernel {
  int bits;  ///< of its vectors
  /// v' = v + d V, Eq. 1 as printed over the sides, 2, 3, 4, 6 and 8 with equal weights, for a group of one
  /// valence, with rings. Where the neighbours of a triangle cancel out or have no area, it offsets nothing,
  /// as its own plane would: its corners lie in that. With `only_offset` writes V alone, for who has another
  /// d.
  void (*move)(const ValenceOrder::Group& group, bool only_offset, float per_squared_scale,
               std::span<const SimdVec3> from, std::span<SimdVec3> to);
};

/// The widest of this processor.
const Kernel& kernel();
/// All that this processor can run, for the test that they agree.
std::vector<Kernel> kernels_here();

/// Eq. 6, min(e^x, 1.5) for x >= 0, to float accuracy.
float exponential_coefficient(float x);

}  // namespace burnish::adaptive_kernels
