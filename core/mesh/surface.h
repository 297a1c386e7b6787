// From a file's vertices and triangles to the welded surface that is smoothed, and back.
#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/topology.h"

namespace burnish {

/// The mesh to smooth: positions that coincide are one vertex; triangles without area by index, and second
/// copies of a triangle, are left out. All are still in the file: `weld` leads from its vertices to these.
struct Surface {
  Mesh mesh;
  Topology topology;
  std::vector<Index> weld;             ///< file vertex -> mesh vertex
  std::vector<Index> source_triangle;  ///< mesh triangle -> file triangle
  std::vector<std::uint8_t> pinned;    ///< per mesh vertex, 1: it must not move; empty: none is pinned
  double mean_edge = 0;                ///< h, in local units (see Frame)
  std::uint32_t welded_vertices = 0;   ///< file vertices that share their position with an earlier one
  std::uint32_t degenerate_triangles = 0;
  std::uint32_t duplicate_triangles = 0;
  Index first_degenerate = kNone;  ///< file triangle
  Index first_duplicate = kNone;   ///< file triangle
};

/// Largest magnitude of a coordinate; beyond it squares of squares leave double.
inline constexpr double kLargestCoordinate = 1e60;

/// Names a file's element for a message: "triangle 812 (line 10321)".
using PlaceName = std::function<std::string(Index)>;

/// Welds, drops, centres and builds the topology. The positions must be finite and at most
/// kLargestCoordinate, the triangles in range: check_mesh() says so. Equal positions are one vertex where
/// their `parts` are equal too; empty: all are. Errors: Cancelled, DeadlineExceeded.
Result<Surface> prepare_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                const RunControl& run, std::span<const Index> parts = {});

/// Everything that foreign arrays must satisfy before anything else touches them. `vertex_place` and
/// `triangle_place` name the culprit. Errors: EmptyMesh, IndexOutOfRange, NonFinitePosition.
Result<> check_mesh(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                    const PlaceName& vertex_place, const PlaceName& triangle_place);

/// What is unusual about the surface, one warning per kind, each naming its first place.
std::vector<Warning> surface_warnings(const Surface& surface, const PlaceName& vertex_place,
                                      const PlaceName& triangle_place);

/// Where a file's vertices went: the view that codecs write from. Spans must outlive it.
struct MovedPositions {
  std::span<const Vec3d> original;  ///< file vertices, file unit
  std::span<const Index> weld;
  std::span<const Vec3f> before, after;  ///< mesh vertices, local units
  Frame frame;

  bool moved(Index file_vertex) const { return !(before[weld[file_vertex]] == after[weld[file_vertex]]); }
  /// Parsed position plus displacement in double, so coordinates far from the origin keep their digits. Never
  /// past kLargestCoordinate, where rounding alone may move one: readers take no such number.
  Vec3d at(Index file_vertex) const {
    const Index v = weld[file_vertex];
    Vec3d to = original[file_vertex] + (to_double(after[v]) - to_double(before[v])) * frame.scale();
    for (std::size_t axis = 0; axis < 3; ++axis)
      to[axis] = std::clamp(to[axis], -kLargestCoordinate, kLargestCoordinate);
    return to;
  }
};

/// Normal of a set of corners: the normalised sum of the face normals, weighted by the corner's angle; zero
/// when that sum vanishes. `corner_rows[t]` gives, for file triangle t, the row that each of its corners adds
/// to (kNone: none). `rows` normals result; `touched[r]` is set where a triangle that cites r has a moved
/// vertex. Errors: Cancelled, DeadlineExceeded.
struct CornerNormals {
  std::vector<Vec3f> normals;
  std::vector<std::uint8_t> touched;
};
Result<CornerNormals> corner_normals(const MovedPositions& moved, std::span<const Triangle> triangles,
                                     std::span<const Triangle> corner_rows, std::size_t rows,
                                     const RunControl& run);

}  // namespace burnish
