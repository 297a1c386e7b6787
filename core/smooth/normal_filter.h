// What the methods share that filter face normals and then move vertices to fit them: the faces of an
// iteration in flat arrays, their neighbours, and the moves.
//
// Old normals are read and new ones written (Jacobi). A triangle without area has the normal 0 and neither
// gives nor takes part, except that a filter may give it one. Where triangles wind against each other the
// normals are turned so that neighbours across an edge agree, which is also what neighbours across a vertex
// see; the moves do not depend on a normal's sign. On a surface without a consistent side, such as a Moebius
// strip, some edges are left where they do not agree.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/faces_around.h"
#include "core/run/buffer.h"
#include "core/run/parallel.h"
#include "core/smooth/iteration.h"
#include "core/smooth/umbrella.h"

namespace burnish {

/// Whose normals are averaged: triangles across the three edges, or all that share a vertex (FacesAround).
/// Never the triangle itself. Edges where three or more triangles meet do not make neighbours by edge.
enum class FaceNeighbourhood : std::uint8_t { Edges, Vertices };

/// `sum` made a unit vector; `otherwise` where it vanishes beside `weights`, the sum of what was added, and
/// is only rounding.
inline SimdVec3 unit_or(SimdVec3 sum, float weights, SimdVec3 otherwise) {
  constexpr float kVanishing = 1e-6F;
  const float size = length(sum);
  return size > kVanishing * weights ? sum * (1 / size) : otherwise;
}

/// Normals, areas and centroids of the faces. Everything is in local units.
class Faces {
 public:
  Faces(const Surface& surface, FaceNeighbourhood neighbourhood, const RunControl& run);

  /// All three from positions. False when stopped.
  bool measure(std::span<const SimdVec3> positions);
  struct Measured {
    SimdVec3 normal, centroid;
    float twice_area;
  };
  /// The same of one face, without keeping it.
  Measured measured(std::span<const SimdVec3> positions, std::size_t f) const {
    const auto& [a, b, c] = surface_.mesh.triangles[f];
    const SimdVec3 area_normal = cross(positions[b] - positions[a], positions[c] - positions[a]);
    const float twice_area = length(area_normal);
    return {twice_area > 0 ? area_normal * (side(f) / twice_area) : SimdVec3{}, centroid_of(positions, f),
            twice_area};
  }
  /// Centroids alone, for normals that are kept while vertices move. False when stopped.
  bool measure_centroids(std::span<const SimdVec3> positions);
  /// Gives their memory back until they are measured again.
  void release_centroids() { Buffer<SimdVec3>().swap(centroids_); }

  /// Replaces every normal by next(f); `next` reads the old ones. False when stopped.
  template <class Next>
  bool filter(Next&& next) {
    return filter_with(0, [&](int, std::size_t f) { return next(f); });
  }
  /// The same by next(scratch, f); each block starts with a copy of `scratch`.
  template <class Scratch, class Next>
  bool filter_with(const Scratch& scratch, Next&& next) {
    const bool done = for_each_block([&](std::size_t begin, std::size_t end) {
      Scratch own = scratch;
      for (std::size_t f = begin; f < end; ++f) next_normals_[f] = next(own, f);
    });
    normals_.swap(next_normals_);
    return done;
  }
  /// body(begin, end) over all faces, in parallel. False when stopped.
  template <class Body>
  bool for_each_block(Body&& body) const {
    return parallel_for(normals_.size(), run_, body);
  }

  std::size_t size() const { return normals_.size(); }
  std::span<const SimdVec3> normals() const { return normals_; }
  /// For a filter that needs two fields of normals; `other` has as many entries. False when stopped.
  bool copy_normals(Buffer<SimdVec3>& other) const {
    return for_each(normals_.size(), run_, [&](std::size_t f) { other[f] = normals_[f]; });
  }
  void swap_normals(Buffer<SimdVec3>& other) { normals_.swap(other); }
  SimdVec3 normal(std::size_t f) const { return normals_[f]; }
  SimdVec3 centroid(std::size_t f) const { return centroids_[f]; }
  float twice_area(std::size_t f) const { return twice_areas_[f]; }
  /// 1, or -1 where the normal is turned against the winding.
  float side(std::size_t f) const { return orientation_.empty() ? 1.0F : orientation_[f]; }
  const Surface& surface() const { return surface_; }
  const RunControl& run() const { return run_; }

  /// visit(neighbour) for each neighbour of f, once.
  template <class Visit>
  void for_each_neighbour(std::size_t f, Visit&& visit) const {
    if (neighbourhood_ == FaceNeighbourhood::Edges) {
      for (const Index neighbour : surface_.topology.face_neighbours[f]) {
        if (neighbour != kNone) visit(neighbour);
      }
    } else {
      around_.for_each(f, visit);
    }
  }

  /// The area-weighted mean of the neighbours' normals, as a unit vector; f's own where it vanishes.
  SimdVec3 mean_of_neighbours(std::size_t f) const;

  /// The mean distance between the centroids of triangles across an edge; 0 when no triangles share one.
  double mean_centroid_distance() const;

  /// Sum over faces f at v of A(f) [(c(f) - p) . n(f)] n(f) over sum of A(f): the move of [5] and [7].
  SimdVec3 offset_by_area(SimdVec3 p, std::size_t v) const {
    SimdVec3 sum;
    float areas = 0;
    for (const Index f : surface_.topology.vertex_faces[v]) {
      sum += normals_[f] * (twice_areas_[f] * dot(centroids_[f] - p, normals_[f]));
      areas += twice_areas_[f];
    }
    return areas > 0 ? sum * (1 / areas) : SimdVec3{};
  }

  /// The same with equal weights: the move of Sun et al. 2007.
  SimdVec3 offset_by_count(SimdVec3 p, std::size_t v) const {
    const auto faces = surface_.topology.vertex_faces[v];
    SimdVec3 sum;
    for (const Index f : faces) sum += normals_[f] * dot(centroids_[f] - p, normals_[f]);
    return sum * (1 / static_cast<float>(faces.size()));
  }

  /// The umbrella vector of v without its part along the area-weighted normal of the faces at v: evens out
  /// the triangles within the surface. 0 on open edges, which would shrink.
  SimdVec3 tangential_umbrella(std::span<const SimdVec3> positions, std::size_t v) const {
    if (surface_.topology.has(static_cast<Index>(v), kBoundaryVertex)) return {};
    SimdVec3 sum;
    float areas = 0;
    for (const Index f : surface_.topology.vertex_faces[v]) {
      sum += normals_[f] * twice_areas_[f];
      areas += twice_areas_[f];
    }
    const SimdVec3 normal = unit_or(sum, areas, {}), way = umbrella(positions, surface_.topology, v);
    return way - normal * dot(way, normal);
  }

 private:
  SimdVec3 centroid_of(std::span<const SimdVec3> positions, std::size_t f) const {
    const auto& [a, b, c] = surface_.mesh.triangles[f];
    return (positions[a] + positions[b] + positions[c]) * (1.0F / 3.0F);
  }

  const Surface& surface_;
  const FaceNeighbourhood neighbourhood_;
  const RunControl& run_;
  const FacesAround around_;
  std::vector<float> orientation_;                       // 1 or -1 per face; empty: all 1
  Buffer<SimdVec3> normals_, next_normals_, centroids_;  // filled by measure()
  Buffer<float> twice_areas_;
};

/// One iteration of such a method.
struct NormalPasses {
  /// Measures the faces and filters their normals. False when stopped.
  std::function<bool(std::span<const SimdVec3> from)> filter;
  /// Moves vertices to fit the normals as they are, as Passes::move; see move_by().
  std::function<void(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
                     std::size_t end)>
      move;
  /// How often the vertices move before the normals are filtered again. Constraints hold after each.
  std::uint32_t vertex_steps = 1;
  /// What each of these moves needs of all positions first. False when it stopped half-way. May be empty.
  std::function<bool(std::span<const SimdVec3> from)> before_move = {};
};

/// The move v' = v + offset(positions, v).
template <class Offset>
auto move_by(const Constraints& constraints, Offset offset) {
  return [movable = constraints.movable(), offset](std::span<const SimdVec3> from, std::span<SimdVec3> to,
                                                   std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (movable[v]) to[v] = from[v] + offset(from, v);
    }
  };
}

/// The move v' = v + offset_by_count(v).
inline auto move_to_fit(const Constraints& constraints, const Faces& faces) {
  return move_by(constraints, [&faces](std::span<const SimdVec3> from, std::size_t v) {
    return faces.offset_by_count(from[v], v);
  });
}

/// iterate() over them. Errors: Cancelled, DeadlineExceeded.
Result<SmoothOutcome> iterate_normals(Surface& surface, Faces& faces, const Constraints& constraints,
                                      const IterationOptions& options, const NormalPasses& passes);

/// The parameter `neighbourhood`, and its value.
ParameterSpec neighbourhood_parameter(FaceNeighbourhood standard);
FaceNeighbourhood neighbourhood_of(const ParameterValues& values);

/// The parameter `vertex_steps`, and a parameter of this name for a Gaussian of the distance of centroids.
ParameterSpec vertex_steps_parameter(std::uint32_t standard);
ParameterSpec centroid_distance_parameter(std::string name, double standard);

}  // namespace burnish
