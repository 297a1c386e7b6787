// Polygons, which are triangles inside only.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/mesh.h"

namespace burnish {

/// Appends the fan of a polygon with three corners at least. `face_of_triangle` stays empty until a polygon
/// has more than three.
inline void add_fan(std::span<const Index> corners, Index face, std::vector<Triangle>& triangles,
                    std::vector<Index>& face_of_triangle) {
  if (face_of_triangle.empty() && corners.size() > 3) {
    face_of_triangle.resize(triangles.size());
    for (Index t = 0; t < face_of_triangle.size(); ++t) face_of_triangle[t] = t;
  }
  const bool remember = corners.size() > 3 || !face_of_triangle.empty();
  for (std::size_t c = 2; c < corners.size(); ++c) {
    triangles.push_back({corners[0], corners[c - 1], corners[c]});
    if (remember) face_of_triangle.push_back(face);
  }
}

}  // namespace burnish
