#include <algorithm>
#include <cmath>

#include "core/mesh/surface.h"

namespace burnish {
namespace {

Index first_file_vertex(const Surface& surface, VertexFlag flag) {
  for (Index v = 0; v < surface.weld.size(); ++v) {
    if (surface.topology.has(surface.weld[v], flag)) return v;
  }
  return kNone;
}

Index first_opposed_triangle(const Surface& surface) {
  const auto& opposed = surface.topology.opposed_neighbours;
  Index first = kNone;
  for (std::size_t t = 0; t < opposed.size(); ++t) {
    if (opposed[t] != 0) first = std::min(first, surface.source_triangle[t]);
  }
  return first;
}

std::string times(std::uint32_t count, const char* one, const char* many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

}  // namespace

Result<> check_mesh(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                    const PlaceName& vertex_place, const PlaceName& triangle_place) {
  if (positions.empty()) return Error{Cause::EmptyMesh, "the mesh has no vertex"};
  if (triangles.empty()) return Error{Cause::EmptyMesh, "the mesh has no face"};
  for (std::size_t v = 0; v < positions.size(); ++v) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = positions[v][axis];
      if (std::abs(value) <= kLargestCoordinate) continue;  // false for NaN
      const std::string what = std::isfinite(value) ? " is beyond 1e60" : " is not a finite number";
      return Error{Cause::NonFinitePosition,
                   vertex_place(static_cast<Index>(v)) + ": coordinate " + "xyz"[axis] + what};
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const Index v : triangles[t]) {
      if (v < positions.size()) continue;
      return Error{Cause::IndexOutOfRange, triangle_place(static_cast<Index>(t)) + " uses vertex " +
                                               std::to_string(v) + " of " + std::to_string(positions.size())};
    }
  }
  return {};
}

std::vector<Warning> surface_warnings(const Surface& surface, const PlaceName& vertex_place,
                                      const PlaceName& triangle_place) {
  std::vector<Warning> warnings;
  const auto add = [&](std::uint32_t count, const char* code, const std::string& message) {
    warnings.push_back({code, message, count});
  };
  const Topology& topology = surface.topology;
  if (surface.welded_vertices > 0) {
    add(surface.welded_vertices, "welded_vertices",
        times(surface.welded_vertices, "vertex shares its position with an earlier one and moves",
              "vertices share their position with an earlier one and move") +
            " with it");
  }
  if (surface.degenerate_triangles > 0) {
    add(surface.degenerate_triangles, "degenerate_triangles",
        times(surface.degenerate_triangles, "triangle has two corners", "triangles have two corners") +
            " at one position and took no part; first: " + triangle_place(surface.first_degenerate));
  }
  if (surface.duplicate_triangles > 0) {
    add(surface.duplicate_triangles, "duplicate_triangles",
        times(surface.duplicate_triangles, "triangle repeats an earlier one",
              "triangles repeat an earlier one") +
            " and took no part; first: " + triangle_place(surface.first_duplicate));
  }
  if (topology.boundary_edges > 0) {
    add(topology.boundary_edges, "boundary_edges",
        times(topology.boundary_edges, "edge has", "edges have") +
            " one triangle only; first: " + vertex_place(first_file_vertex(surface, kBoundaryVertex)));
  }
  if (topology.non_manifold_edges > 0) {
    add(topology.non_manifold_edges, "non_manifold_edges",
        times(topology.non_manifold_edges, "edge has", "edges have") + " three or more triangles");
  }
  if (topology.non_manifold_vertices > 0) {
    add(topology.non_manifold_vertices, "non_manifold_vertices",
        times(topology.non_manifold_vertices, "vertex joins", "vertices join") +
            " several fans of triangles and stayed in place; first: " +
            vertex_place(first_file_vertex(surface, kNonManifoldVertex)));
  }
  if (topology.isolated_vertices > 0) {
    add(topology.isolated_vertices, "isolated_vertices",
        times(topology.isolated_vertices, "vertex is", "vertices are") +
            " in no triangle with area and stayed in place; first: " +
            vertex_place(first_file_vertex(surface, kIsolatedVertex)));
  }
  if (topology.opposed_edges > 0) {
    add(topology.opposed_edges, "inconsistent_orientation",
        times(topology.opposed_edges, "edge joins", "edges join") +
            " triangles that wind against each other; first: " +
            triangle_place(first_opposed_triangle(surface)));
  }
  return warnings;
}

}  // namespace burnish
