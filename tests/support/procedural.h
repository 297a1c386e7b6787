// Our own shapes with a known truth, to measure denoising with and to learn from: machine parts, free forms,
// and both in one. Their meshes are as uneven as real ones: sizes and aspects of triangles vary, vertices are
// moved within the surface, diagonals run either way, and edges run along every crease.
#pragma once

#include <string_view>

#include "tests/support/shapes.h"

namespace burnish::testing {

enum class Family : std::uint8_t { Machined, FreeForm, Mixed };

struct NamedShape {
  std::string name;
  Family family;
  bool closed;
  Shape shape;  ///< about 2 across, wound outwards
};

/// Every kind, in the order of procedural_shapes().
std::vector<std::string> procedural_names();

/// The kind's shape with about `resolution` triangles (1000 to 100 000; within a tenth). The seed chooses its
/// proportions and its mesh; the same seed gives the same bytes, and the same proportions at any resolution.
/// Aborts for an unknown name.
NamedShape procedural_shape(std::string_view name, std::uint64_t seed, std::size_t resolution = 10'000);

/// One of every kind.
std::vector<NamedShape> procedural_shapes(std::uint64_t seed, std::size_t resolution = 10'000);

}  // namespace burnish::testing
