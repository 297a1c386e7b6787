// Who is next to whom, in flat arrays. Built once per job; methods and measures only read it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/run/run_control.h"

namespace burnish {

/// Rows of indices of different lengths in one array (compressed sparse rows).
struct IndexRows {
  std::vector<Index> offsets;  ///< rows + 1
  std::vector<Index> items;

  std::size_t rows() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  std::span<const Index> operator[](std::size_t row) const {
    return {items.data() + offsets[row], items.data() + offsets[row + 1]};
  }
};

enum VertexFlag : std::uint8_t {
  kBoundaryVertex = 1,  ///< on an edge that has one triangle
  kNonManifoldVertex =
      2,                ///< on an edge with three or more triangles, or where several fans of triangles meet
  kIsolatedVertex = 4,  ///< in no triangle
};

struct Topology {
  IndexRows vertex_faces;       ///< triangles at each vertex, ascending
  IndexRows vertex_neighbours;  ///< vertices that share an edge with each vertex, ascending
  /// Per triangle (a, b, c) the triangle across the edges ab, bc, ca; kNone at the boundary and where three
  /// or more triangles meet.
  std::vector<Triangle> face_neighbours;
  /// Bit e of entry t: the neighbour across edge e winds the other way. Empty when all triangles agree.
  std::vector<std::uint8_t> opposed_neighbours;
  std::vector<std::uint8_t> vertex_flags;  ///< VertexFlag bits

  std::uint32_t edges = 0;
  std::uint32_t boundary_edges = 0;
  std::uint32_t non_manifold_edges = 0;
  std::uint32_t opposed_edges = 0;  ///< edges whose two triangles wind against each other
  std::uint32_t non_manifold_vertices = 0;
  std::uint32_t isolated_vertices = 0;
  std::uint32_t components = 0;     ///< sets of triangles connected by vertices
  bool repeated_triangles = false;  ///< two triangles have the same corners: the rest means nothing then

  /// Pairs of triangles that are neighbours across an edge.
  std::uint32_t adjacent_pairs() const { return edges - boundary_edges - non_manifold_edges; }
  bool has(Index vertex, VertexFlag flag) const { return (vertex_flags[vertex] & flag) != 0; }
  /// The neighbour of triangle t across its edge e winds the other way.
  bool opposed(std::size_t t, std::size_t e) const {
    return !opposed_neighbours.empty() && (opposed_neighbours[t] >> e & 1) != 0;
  }
};

/// O(n log(highest valence)). The triangles' indices must be in range and distinct within each triangle. No
/// two triangles should have the same corners: prepare_surface() sees to that, by asking repeated_triangles.
/// Errors: Cancelled, DeadlineExceeded.
Result<Topology> build_topology(std::size_t vertices, std::span<const Triangle> triangles,
                                const RunControl& run);

/// Mean length of the edges, h; 0 when there is none.
double mean_edge_length(std::span<const Vec3f> positions, const Topology& topology, const RunControl& run);

}  // namespace burnish
