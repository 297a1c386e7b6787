// Small meshes to test with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/surface.h"

namespace burnish::testing {

struct Shape {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
};

/// An icosahedron whose faces were split `levels` times, on the unit sphere: 20 * 4^levels triangles.
Shape sphere(int levels);
/// n x n squares of side 1 in the plane z = 0, each split in two: an open mesh of 2 n^2 triangles.
Shape grid(int n);
/// An axis-parallel cube from -1 to 1, each side n x n squares: sharp edges and flat sides, closed.
Shape cube(int n);

/// Adds uniform noise in [-amplitude, amplitude] to every coordinate.
Shape with_noise(Shape shape, double amplitude, std::uint64_t seed = 1);
Shape scaled(Shape shape, double factor);
Shape moved(Shape shape, const Vec3d& by);
/// Turned by the rotation around (1, 2, 3) by one radian.
Shape rotated(Shape shape);
Vec3d rotated(const Vec3d& p);
/// Vertex i becomes vertex order[i].
Shape with_vertex_order(const Shape& shape, const std::vector<Index>& order);
/// A fixed shuffle of 0 to n - 1.
std::vector<Index> shuffled(std::size_t n);

/// The surface of a shape; aborts on an error, because the shapes are ours.
Surface surface_of(const Shape& shape);
std::string to_obj(const Shape& shape);

/// A file of the real meshes, "pairs/Bunny0.2/Noisy.obj"; its text is empty when the machine does not have
/// it.
std::filesystem::path real_mesh(const std::string& name);
std::string read_file(const std::filesystem::path& path);

}  // namespace burnish::testing
