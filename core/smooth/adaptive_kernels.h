// The passes of `adaptive` over many triangles and vertices at once, with the widest vectors that the
// processor has. Whatever their width, every number comes out of the same operations in the same order: the
// same bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/smooth/valence_order.h"

namespace burnish::adaptive_kernels {

using Row = SimdVec3::Lanes;  ///< four floats

/// Passes over triangles go by so many: their arrays are filled up to a multiple of it.
inline constexpr std::size_t kTrianglesAtOnce = 8;

/// Below this share of the summed areas the weighted normals cancel out, and their sum is only rounding.
inline constexpr float kVanishing = 1e-6F;

struct Kernels {
  int bits;  ///< of its vectors
  /// Fills area_normals[f] = (n, |n|), n the normal times twice the area, for the triangles in [begin, end),
  /// multiples of kTrianglesAtOnce, and leaves in `planes` what expect() asks there. Three corners per
  /// triangle, as doubled().
  void (*measure)(std::span<const std::uint32_t> corners, std::span<const SimdVec3> from, std::size_t begin,
                  std::size_t end, std::span<Row> area_normals, std::span<Row> planes);
  /// After measure() of all triangles: makes planes[f] = (m, m . C), m the expected normal of Eq. 1 over the
  /// sides, as printed, and C the centroid. Three rows of area_normals per triangle, as doubled(), of the
  /// triangles across its sides.
  void (*expect)(std::span<const std::uint32_t> across, std::span<const Row> area_normals, std::size_t begin,
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
