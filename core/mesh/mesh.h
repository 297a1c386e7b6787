// The triangle mesh that everything in core works on.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/mesh/vec3.h"

namespace burnish {

using Index = std::uint32_t;
using Triangle = std::array<Index, 3>;
inline constexpr Index kNone = ~Index{0};

/// Where a mesh's float coordinates sit in the file's space: file = centre + local * 2^exponent.
/// Centring keeps the precision of scans far from the origin; the power of two is exact, keeps squares and
/// cubes of any model's size within float, and makes the result independent of the unit.
struct Frame {
  Vec3d centre;
  int exponent = 0;  ///< -900 to 201

  double scale() const { return std::ldexp(1.0, exponent); }  ///< length in the file's unit of one local unit
  Vec3d to_file(const Vec3d& local) const { return centre + local * scale(); }
  Vec3f to_local(const Vec3d& file) const {
    // A product with a power of two rounds as ldexp does, in a tenth of its time.
    return to_float((file - centre) *
                    std::bit_cast<double>(static_cast<std::uint64_t>(1023 - exponent) << 52));
  }
};

/// Positions in the frame (bounding box around 0, its diagonal in [1, 2)) and triangles with distinct
/// corners.
struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<Triangle> triangles;
  Frame frame;
};

}  // namespace burnish
