// The sample: a made-up scan that has what smoothing must tell apart, sharp edges and round flanks.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/run/error.h"

namespace burnish {

struct Shape {
  std::vector<Vec3d> positions;  ///< millimetres
  std::vector<Triangle> triangles;
};

inline constexpr unsigned kSampleResolution = 44;  ///< 23232 triangles

/// A cube of 100 mm with a dome, a bowl, a steep and a shallow pyramid, a sunk pyramid and a flat base, one
/// per side: closed, one component, 12 resolution^2 triangles. Every sharp edge runs along edges of the mesh.
/// `resolution`: cells per side, 4 to 1000, rounded up to a multiple of 4. Errors: BadOption.
Result<Shape> make_sample(unsigned resolution = kSampleResolution);

}  // namespace burnish
