// The passes of `adaptive` over many triangles and vertices at once, with the widest vectors that the
// processor has. Whatever their width, every number comes out of the same operations in the same order: the
// same bits.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/smooth/valence_order.h"

namespace burnish::adaptive_kernels {

using Row = SimdVec3::Lanes;  ///< four floats

/// A triangle's corners and, for each side, the far corner of the triangle across it, or an end of that side
/// when there is none: that triangle then has no area. All as doubled().
struct Wings {
  std::array<std::uint32_t, 3> corners, far_corners;
};

/// Below this share of the summed areas the weighted normals cancel out, and their sum is only rounding.
inline constexpr float kVanishing = 1e-6F;

struct Kernels {
  int bits;  ///< of its vectors
  /// Fills planes[f] = (m, m . C), m the expected normal of Eq. 1 over the sides, as printed, and C the
  /// centroid, for the triangles in [begin, end).
  void (*expect)(std::span<const Wings> wings, std::span<const SimdVec3> from, std::size_t begin,
                 std::size_t end, std::span<Row> planes);
  /// v' = v + d V, Eq. 2, 3, 4, 6 and 8 with equal weights, for a group of one valence, with faces.
  void (*move)(const ValenceOrder::Group& group, std::span<const Row> planes, float per_squared_scale,
               std::span<const SimdVec3> from, std::span<SimdVec3> to);
};

/// The widest of this processor.
const Kernels& kernels();
/// All that this processor can run, for the test that they agree.
std::vector<Kernels> kernels_here();

/// Eq. 6, min(e^x, 1.5) for x >= 0, to float accuracy.
float exponential_coefficient(float x);

}  // namespace burnish::adaptive_kernels
