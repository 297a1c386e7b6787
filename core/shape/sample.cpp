#include "core/shape/sample.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace burnish {
namespace {

constexpr double kHalfSide = 50;  // mm

/// A dome (or a bowl when negative) with a tangent plane everywhere.
double dome(double u, double v, double height) {
  const double rest = std::max(0.0, 1 - (u * u + v * v) / 0.81);
  return height * rest * rest;
}

/// A pyramid over the middle half of the side: its creases run along u = +-v and along its foot.
double pyramid(double u, double v, double height) {
  return height * std::max(0.0, 1 - 2 * std::max(std::abs(u), std::abs(v)));
}

/// What stands on a side of the cube [-1, 1]^3 at (u, v) in [-1, 1]^2; 0 along its border.
double relief(int axis, bool positive, double u, double v) {
  switch (2 * axis + (positive ? 1 : 0)) {
    case 0:
      return pyramid(u, v, -0.35);
    case 1:
      return pyramid(u, v, 0.45);
    case 2:
      return pyramid(u, v, 0.15);
    case 3:
      return dome(u, v, -0.4);
    case 5:
      return dome(u, v, 0.6);
    default:
      return 0;
  }
}

/// Builds side after side; sides share the vertices of their borders.
class SampleBuilder {
 public:
  explicit SampleBuilder(unsigned cells) : cells_(static_cast<int>(cells)) {
    for (int axis = 0; axis < 3; ++axis) {
      add_side(axis, false);
      add_side(axis, true);
    }
  }

  Shape shape;

 private:
  void add_side(int axis, bool positive) {
    for (int i = 0; i < cells_; ++i) {
      for (int j = 0; j < cells_; ++j) add_cell(axis, positive, i, j);
    }
  }

  void add_cell(int axis, bool positive, int i, int j) {
    std::array<Index, 4> ring = {vertex(axis, positive, i, j), vertex(axis, positive, i + 1, j),
                                 vertex(axis, positive, i + 1, j + 1), vertex(axis, positive, i, j + 1)};
    const bool rising =
        (2 * i + 1 < cells_) == (2 * j + 1 < cells_);  // the diagonal that points at the middle
    if (!rising) std::rotate(ring.begin(), ring.begin() + 1, ring.end());
    if (!positive) std::swap(ring[1], ring[3]);
    shape.triangles.push_back({ring[0], ring[1], ring[2]});
    shape.triangles.push_back({ring[0], ring[2], ring[3]});
  }

  Index vertex(int axis, bool positive, int i, int j) {
    std::array<int, 3> grid{};
    grid[static_cast<std::size_t>(axis)] = positive ? cells_ : 0;
    grid[static_cast<std::size_t>((axis + 1) % 3)] = i;
    grid[static_cast<std::size_t>((axis + 2) % 3)] = j;
    const std::uint64_t side = static_cast<std::uint64_t>(cells_) + 1;
    const std::uint64_t key =
        (static_cast<std::uint64_t>(grid[0]) * side + static_cast<std::uint64_t>(grid[1])) * side +
        static_cast<std::uint64_t>(grid[2]);
    const auto [entry, added] = index_of_.try_emplace(key, static_cast<Index>(shape.positions.size()));
    if (added) {
      Vec3d p = {unit(grid[0]), unit(grid[1]), unit(grid[2])};
      const double height = relief(axis, positive, unit(i), unit(j));
      p[static_cast<std::size_t>(axis)] += positive ? height : -height;
      shape.positions.push_back(p * kHalfSide);
    }
    return entry->second;
  }

  double unit(int line) const { return 2.0 * line / cells_ - 1; }

  int cells_;
  std::unordered_map<std::uint64_t, Index> index_of_;
};

}  // namespace

Result<Shape> make_sample(unsigned resolution) {
  if (resolution < 4 || resolution > 1000) {
    return Error{Cause::BadOption, "resolution must be from 4 to 1000 cells per side", "resolution"};
  }
  return std::move(SampleBuilder((resolution + 3) / 4 * 4).shape);
}

}  // namespace burnish
