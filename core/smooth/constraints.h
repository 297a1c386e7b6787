// Where the vertices of a mesh may go, whatever the method: some stay, some slide along a sharp edge, none
// goes farther than the caller allows.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/mesh/surface.h"

namespace burnish {

enum class BoundaryRule : std::uint8_t {
  Fixed,  ///< vertices on open edges stay where they are
  Free,   ///< they move as the method says
};

struct ConstraintOptions {
  BoundaryRule boundary = BoundaryRule::Fixed;
  /// No vertex ends farther than this from where it came, in local units; 0 = no bound.
  double max_displacement = 0;
  /// Edges of the input with a larger angle between the normals of their triangles, in degrees, keep their
  /// line: a vertex with two of them only slides along them, one with one, three or more stays. 0 = none.
  double lock_features = 0;
};

/// Built once per run from the mesh as it came, whose positions must stay as they are meanwhile. Thread-safe.
class Constraints {
 public:
  /// When `run` stops it half-way, nothing is movable in what was not looked at.
  Constraints(const Surface& surface, const ConstraintOptions& options, const RunControl& run = {});

  /// Per vertex, 1 when a method may move it: not isolated, not non-manifold, not pinned, not on a fixed
  /// boundary, not where sharp edges meet or end.
  std::span<const std::uint8_t> movable() const { return movable_; }

  /// Takes the movable vertices in [begin, end) of `to` to the allowed place that is nearest, or, for the
  /// bound on the displacement, that lies on their way. False when one has left the mesh or is not a number.
  bool enforce(std::span<SimdVec3> to, std::size_t begin, std::size_t end) const;

 private:
  using Edge = std::array<Index, 2>;

  void lock(const Surface& surface, double degrees, const RunControl& run);
  Vec3f slide(std::size_t vertex, const Vec3f& p) const;

  std::span<const Vec3f> home_;
  std::vector<std::uint8_t> movable_;
  std::vector<Edge> rails_;  ///< the far ends of the sharp edges of a vertex that slides; empty: none slides
  double limit_ = 0;
  bool limited_ = false;
};

}  // namespace burnish
