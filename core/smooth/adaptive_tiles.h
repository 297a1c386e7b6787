// What `adaptive` needs to smooth one block of vertices after the other, each in one go: the triangles at its
// vertices and those across their sides, numbered within the block, so that their normals and planes stay in
// a thread's cache. What lies on the rim of two blocks is computed for both: a tenth more work, and a third
// of the memory traffic (docs/decisions/0009-order-of-work.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/run/buffer.h"
#include "core/smooth/valence_order.h"

namespace burnish {

class AdaptiveTiles {
 public:
  /// All indices as doubled().
  struct Tile {
    Buffer<std::uint32_t> corners;  ///< three vertices per triangle
    /// Three triangles of the tile per triangle at its vertices: those across its sides. none() where there
    /// is none, turned(n) for a neighbour n that winds the other way.
    Buffer<std::uint32_t> across;
    /// The triangles at each vertex, in the order of ValenceOrder's groups and vertices.
    Buffer<std::uint32_t> faces;

    std::size_t triangles() const { return corners.size() / 3; }  ///< those at its vertices come first
    std::size_t expected() const { return across.size() / 3; }    ///< at its vertices
    std::size_t none() const { return triangles(); }
    std::size_t turned(std::size_t n) const { return triangles() + 1 + n; }
    bool any_turned = false;
  };

  /// Numbers of triangles are filled up to a multiple of adaptive_kernels::kTrianglesAtOnce. When `run` stops
  /// it half-way, its tiles mean nothing.
  AdaptiveTiles(std::span<const Triangle> triangles, const Topology& topology, const ValenceOrder& order,
                const RunControl& run);

  /// Of the block of vertices that starts at `begin`, as parallel_for hands it out.
  const Tile& operator[](std::size_t begin) const { return tiles_[begin / block_size_]; }

 private:
  std::size_t block_size_;
  std::vector<Tile> tiles_;
};

}  // namespace burnish
