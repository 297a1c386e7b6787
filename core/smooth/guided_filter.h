// One step of guided normal filtering: face normals are averaged over those whose GUIDANCE is alike, the mean
// normal of the most even patch that contains a face. Noise disturbs it less than the normal itself, and it
// does not reach across edges.
//
// W. Zhang, B. Deng, J. Zhang, S. Bouaziz, L. Liu, Guided mesh normal filtering, Computer Graphics Forum 34
// (Pacific Graphics 2015) 23-34.
#pragma once

#include <array>

#include "core/smooth/normal_filter.h"

namespace burnish {

/// Standard deviations of the two Gaussians.
struct GuidedWidths {
  double sigma_s = 1;     ///< of the distance of centroids, in mean distances of those of adjacent triangles
  double sigma_r = 0.35;  ///< of the length of the difference of guidance normals
};

/// For each face i: its patch P(i), the triangle and all that share a vertex with it; and its neighbours
/// N(i), the patch and all triangles whose centroid is within a radius of its own that a walk over vertices
/// within it leads to. Of a vertex's triangles, and of a face's neighbours, no more than the first kMostNear.
///
/// consistency H(P) = Phi(P) R(P), Phi = largest |n(a) - n(b)| over all pairs in P, R = largest phi(e) over
/// (1e-9 + sum of phi(e)), phi(e) = |n(a) - n(b)| for the two triangles at e, over the edges at the corners
/// of P's middle triangle: all edges with both triangles in P, but for some beside vertices of valence 3.
/// g(i) = unit area-weighted mean normal of the P(j) with the least H among those of j in P(i),
/// n'(i) = unit(sum over j in N(i) of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_s^2) - |g(i) - g(j)|^2 / (2
/// sigma_r^2)) n(j)), n(i) where the sum vanishes. A triangle without area has the normal 0;
/// where three or more meet at an edge, some count twice in the means.
class GuidedFilter {
 public:
  static constexpr std::size_t kMostNear = 128;

  /// Neighbours of the faces as measured; `radius` in mean distances of adjacent centroids. Takes 4 bytes
  /// per neighbour and 100 more per triangle, some 170 in all for radius 2. When stopped, they mean nothing.
  /// The faces' surface and run must outlive it.
  GuidedFilter(const Faces& faces, double radius);

  /// Filters the normals once, with the areas and centroids that the faces have now. The same bits for any
  /// number of threads. False when stopped.
  bool filter(Faces& faces, const GuidedWidths& widths);

 private:
  using Row = SimdVec3::Lanes;  ///< four floats

  /// What a neighbour gives; the places and guides are scaled so that the exponent is minus their squared
  /// distance.
  struct Given {
    Row pull;   ///< twice the area times the normal, and twice the area
    Row place;  ///< centroid
    Row guide;
  };
  struct Ring {  ///< of a vertex
    Row pull = {};
    float sum = 0, most = 0;  ///< of phi
    float unused[2] = {};
  };
  bool give(const Faces& faces, float per_sigma_s);
  bool gather_rings();
  bool rate_patches(const Faces& faces);
  bool guide(float per_sigma_r);
  float largest_difference(std::span<const SimdVec3> normals, std::size_t f) const;
  SimdVec3 filtered(std::size_t f, SimdVec3 own) const;

  std::span<const Index> near(std::size_t f) const {
    return {near_.data() + offsets_[f], near_.data() + offsets_[f + 1]};
  }
  std::span<const Index> patch(std::size_t f) const { return {near_.data() + offsets_[f], patch_sizes_[f]}; }

  const Topology& topology_;
  std::span<const Triangle> triangles_;
  const RunControl& run_;
  // N(i), its patch first; filled up to a multiple of four with a face that gives nothing.
  Buffer<Index> near_;
  std::vector<std::size_t> offsets_;
  Buffer<std::uint8_t> patch_sizes_;
  Buffer<Given> given_;                 // per face, and the one that gives nothing
  Buffer<std::array<float, 3>> turns_;  // phi of the sides
  Buffer<Ring> rings_;                  // per vertex
  Buffer<SimdVec3> means_;
  Buffer<float> consistency_;
};

}  // namespace burnish
