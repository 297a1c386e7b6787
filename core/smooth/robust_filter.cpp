#include "core/smooth/robust_filter.h"

#include <algorithm>

#include "core/smooth/bilateral_filter.h"

namespace burnish {
namespace {

/// One filtering by the spatial Gaussian and the biweight of the differences of `guide`.
bool filter_once(Faces& faces, std::span<const SimdVec3> guide, float per_distance, double threshold) {
  const float per_square = static_cast<float>(1 / (threshold * threshold));
  return filter_by_weights(
      faces,
      [&faces, per_distance](Index j, std::size_t i) {
        const SimdVec3 way = faces.centroid(j) - faces.centroid(i);
        return dot(way, way) * per_distance;
      },
      [guide, per_square](Index j, std::size_t i) {
        const SimdVec3 turn = guide[j] - guide[i];
        const float below = std::max(1 - dot(turn, turn) * per_square, 0.0F);
        return below * below;
      });
}

}  // namespace

bool RobustFilter::filter(Faces& faces, const RobustWidths& widths, std::uint32_t steps) {
  const float per_distance = gaussian_factor(widths.sigma_c * faces.mean_centroid_distance());
  if (!faces.copy_normals(input_)) return false;
  for (std::uint32_t step = 0; step < steps; ++step) {
    if (!filter_once(faces, faces.normals(), per_distance, widths.first_threshold)) return false;
  }
  if (!faces.copy_normals(guide_)) return false;
  faces.swap_normals(input_);
  for (std::uint32_t step = 0; step < steps; ++step) {
    if (!filter_once(faces, guide_, per_distance, widths.second_threshold)) return false;
  }
  return true;
}

}  // namespace burnish
