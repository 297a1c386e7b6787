// What makes a procedural mesh look found, not made: random places, uneven sizes, flipped diagonals.
#pragma once

#include <cstdint>
#include <functional>
#include <random>

#include "core/run/math.h"
#include "tests/support/shapes.h"

namespace burnish::testing {

/// The same numbers on every machine, as those of core/shape/noise.h.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}

  double unit() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }  ///< [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }
  int whole(int low, int high) { return low + static_cast<int>(unit() * (high - low + 1)); }
  bool chance(double share) { return unit() < share; }
  Vec3d direction();                ///< evenly on the unit sphere
  std::array<double, 2> in_disc();  ///< evenly in the unit disc

 private:
  std::mt19937_64 bits_;
};

inline double portable_sin(double x) { return portable_cos(x - kPi / 2); }

/// The smallest of a triangle's angles, degrees.
double smallest_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// Splits the quad a b c d along either diagonal at random, unless one leaves an angle below 15 degrees and
/// the other is better.
void add_quad(Shape& shape, Index a, Index b, Index c, Index d, Random& random);

/// Flips a share of the edges of a manifold mesh: those between triangles of nearly one plane, where no angle
/// falls below 15 degrees. Never one across a crease.
void flip_edges(Shape& shape, double share, Random& random);

/// A surface over nu x nv cells of the unit square, whose inner vertices are moved by up to a third of a cell
/// and whose cells are of uneven size. A direction that wraps has its last cell joined to its first.
struct Wraps {
  bool u = false, v = false;
};
Shape parametric(int nu, int nv, Wraps wraps, const std::function<Vec3d(double u, double v)>& place,
                 Random& random);

/// The surface where `field` is 0, positive inside, within the cube of side 2 around 0, with edges of about
/// `edge`: one vertex in every crossed cell of a grid (surface nets), moved onto the surface, away from the
/// middle of its cell at random.
Shape implicit_surface(const std::function<double(const Vec3d&)>& field, double edge, Random& random);

}  // namespace burnish::testing
