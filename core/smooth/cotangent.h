// Cotangent weights of the Laplace-Beltrami operator [4], for the flows that are built from it.
#pragma once

#include <algorithm>
#include <span>

#include "core/mesh/mesh.h"
#include "core/mesh/simd_vec3.h"

namespace burnish {

/// Per triangle: the clamped cotangents at its corners, halved, and its area.
struct FaceWeights {
  float half_cotangent[3];
  float area;
};

/// Cotangents are clamped to [0, largest]. A triangle without area has the weights 0.
inline FaceWeights face_weights(const Triangle& t, std::span<const SimdVec3> positions, float largest) {
  FaceWeights weights{};
  const SimdVec3 p[3] = {positions[t[0]], positions[t[1]], positions[t[2]]};
  const float twice_area = length(cross(p[1] - p[0], p[2] - p[0]));
  weights.area = twice_area * 0.5F;
  if (twice_area == 0) return weights;  // no direction to flow in
  for (int c = 0; c < 3; ++c) {
    const float cotangent = dot(p[(c + 1) % 3] - p[c], p[(c + 2) % 3] - p[c]) / twice_area;
    weights.half_cotangent[c] = 0.5F * std::clamp(cotangent, 0.0F, largest);
  }
  return weights;
}

/// Which corner of t, 0 to 2, the vertex is.
inline int corner_of(const Triangle& t, std::size_t vertex) {
  return t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
}

}  // namespace burnish
