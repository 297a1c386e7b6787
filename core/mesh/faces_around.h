// The triangles around a triangle: all that share a vertex with it.
#pragma once

#include "core/mesh/surface.h"

namespace burnish {

class FacesAround {
 public:
  /// Triangles at a vertex above which they are neighbours across edges only: a fan of n triangles would be
  /// n^2 pairs.
  static constexpr std::size_t kMost = 128;

  /// The surface must outlive it.
  FacesAround(const Surface& surface, const RunControl& run);

  /// visit(neighbour) for each triangle that shares a vertex with f, once, f itself left out: those at its
  /// first corner, then at the second, then at the third.
  template <class Visit>
  void for_each(std::size_t f, Visit&& visit) const {
    const Triangle& t = mesh_.triangles[f];
    if (has_crowds_ && (crowded(t[0]) || crowded(t[1]) || crowded(t[2]))) {
      for_each_beside_crowds(f, visit);
      return;
    }
    const auto at_corner = [&](std::size_t corner, auto&& seen) {
      for (const Index n : topology_.vertex_faces[t[corner]]) {
        if (n != f && !seen(n)) visit(n);
      }
    };
    at_corner(0, [](Index) { return false; });
    if (topology_.non_manifold_edges == 0) {  // what shares two corners is across their edge
      const Triangle& across = topology_.face_neighbours[f];
      at_corner(1, [&](Index n) { return n == across[0]; });
      at_corner(2, [&](Index n) { return n == across[1] || n == across[2]; });
    } else {
      at_corner(1, [&](Index n) { return has_corner(n, t[0]); });
      at_corner(2, [&](Index n) { return has_corner(n, t[0]) || has_corner(n, t[1]); });
    }
  }

 private:
  /// At a crowded corner only the triangles across its two edges.
  template <class Visit>
  void for_each_beside_crowds(std::size_t f, Visit&& visit) const {
    const Triangle& t = mesh_.triangles[f];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (crowded(t[corner])) continue;
      for (const Index n : topology_.vertex_faces[t[corner]]) {
        bool seen = n == f;
        for (std::size_t before = 0; before < corner; ++before)
          seen = seen || (!crowded(t[before]) && has_corner(n, t[before]));
        if (!seen) visit(n);
      }
    }
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const Index n = topology_.face_neighbours[f][edge];
      if (n != kNone && crowded(t[edge]) && crowded(t[(edge + 1) % 3])) visit(n);
    }
  }
  bool crowded(Index v) const { return topology_.vertex_faces[v].size() > kMost; }
  bool has_corner(Index f, Index vertex) const {
    const Triangle& t = mesh_.triangles[f];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }

  const Mesh& mesh_;
  const Topology& topology_;
  const bool has_crowds_;
};

}  // namespace burnish
