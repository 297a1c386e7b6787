// Filters of face normals whose weights are Gaussians: bilateral (Zheng et al. 2011), joint bilateral, where
// the normals of a guide are compared instead of those that are filtered, and by bending.
#pragma once

#include <algorithm>
#include <span>

#include "core/run/math.h"
#include "core/smooth/normal_filter.h"

namespace burnish {

/// The neighbours of one triangle, and their weights by four: room that one thread uses again and again.
struct WeightedNeighbours {
  std::vector<Index> faces;
  std::vector<FourFloats> weights;
};

/// unit(sum over neighbours j of i of A(j) factor(j, i) exp(exponent(j, i)) n(j)); n(i) where the sum
/// vanishes.
template <class Exponent, class Factor>
SimdVec3 normal_by_weights(const Faces& faces, WeightedNeighbours& near, std::size_t i, Exponent&& exponent,
                           Factor&& factor) {
  near.faces.clear();
  faces.for_each_neighbour(i, [&](Index n) { near.faces.push_back(n); });
  near.weights.resize((near.faces.size() + 3) / 4);
  for (std::size_t k = 0; k < near.faces.size(); ++k) near.weights[k / 4][k % 4] = exponent(near.faces[k], i);
  for (FourFloats& four : near.weights) four = portable_exp(four);
  SimdVec3 sum;
  float weights = 0;
  for (std::size_t k = 0; k < near.faces.size(); ++k) {
    const Index n = near.faces[k];
    const float weight = faces.twice_area(n) * near.weights[k / 4][k % 4] * factor(n, i);
    sum += faces.normal(n) * weight;
    weights += weight;
  }
  return unit_or(sum, weights, faces.normal(i));
}

/// Every normal by normal_by_weights(). False when stopped.
template <class Exponent, class Factor>
bool filter_by_weights(Faces& faces, Exponent&& exponent, Factor&& factor) {
  return faces.filter_with(WeightedNeighbours{}, [&](WeightedNeighbours& near, std::size_t f) {
    return normal_by_weights(faces, near, f, exponent, factor);
  });
}

/// The same with the factor 1.
template <class Exponent>
bool filter_by_weights(Faces& faces, Exponent&& exponent) {
  return filter_by_weights(faces, exponent, [](Index, std::size_t) { return 1.0F; });
}

/// -1 / (2 sigma^2), finite for any sigma >= 0: meshes may have shrunk to a point.
inline float gaussian_factor(double sigma) {
  constexpr double kMost = 1e30;
  return -static_cast<float>(std::min(kMost, 1 / (2 * sigma * sigma)));
}

/// Standard deviations of the two Gaussians.
struct BilateralWidths {
  double sigma_c;  ///< of the distance of centroids, in mean distances of those of adjacent triangles
  double sigma_s;  ///< of the length of the difference of unit normals
};

/// The bilateral exponent -|c(i) - c(j)|^2 / (2 sigma_c^2) - |g(i) - g(j)|^2 / (2 sigma_s^2) of the faces as
/// they are, g the normals of the guide.
class BilateralExponent {
 public:
  BilateralExponent(const BilateralWidths& widths, const Faces& faces, std::span<const SimdVec3> guide)
      : per_distance_(gaussian_factor(widths.sigma_c * faces.mean_centroid_distance())),
        per_difference_(gaussian_factor(widths.sigma_s)),
        faces_(faces),
        guide_(guide) {}

  float operator()(Index j, std::size_t i) const {
    const SimdVec3 way = faces_.centroid(j) - faces_.centroid(i), turn = guide_[j] - guide_[i];
    return dot(way, way) * per_distance_ + dot(turn, turn) * per_difference_;
  }

 private:
  float per_distance_, per_difference_;
  const Faces& faces_;
  std::span<const SimdVec3> guide_;
};

}  // namespace burnish
