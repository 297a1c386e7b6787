// Solids with sharp edges, meshed side by side: each side has its own flat domain, filled with random points
// and triangulated, and shares the vertices along its outline with the sides next to it. So edges of the mesh
// run along every sharp edge, and nothing about it is regular.
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "tests/support/delaunay.h"
#include "tests/support/irregular.h"

namespace burnish::testing {

using Loop = std::vector<Point2>;

class FacetMesher {
 public:
  /// Edges are about `edge` long, 0.7 to 1.4 times that from place to place.
  FacetMesher(double edge, Random& random);

  /// Where to cut a curve over [0, 1] that sides share, both ends included: at least `least` pieces.
  std::vector<double> cuts(const std::function<Vec3d(double)>& curve, int least = 1);

  /// A side: the part of the plane that is within an odd number of loops, whose points are cuts of its
  /// outline, and where it lies in space, by a map that keeps lengths or nearly so. `flipped`: seen from
  /// outside, the map turns the plane over.
  void add(const std::vector<Loop>& loops, const std::function<Vec3d(const Point2&)>& place,
           bool flipped = false);

  /// All sides, joined where their outlines meet, with some edges flipped.
  Shape finish();

 private:
  double size_at(const Vec3d& p) const;
  std::vector<Point2> fill(const std::vector<Loop>& loops, const std::function<Vec3d(const Point2&)>& place);
  Index vertex_at(const Vec3d& p);

  double edge_;
  Random& random_;
  Vec3d wave_;
  double phase_;
  Shape shape_;
  std::map<std::array<std::int64_t, 3>, Index> vertices_;
};

/// One stretch of a profile: a curve over [0, 1] and its length.
struct Stretch {
  std::function<Point2(double)> at;
  double length;
  int least = 1;  ///< pieces to cut it into
};
Stretch line(Point2 from, Point2 to);
/// From an angle to another, radians, counter-clockwise when growing.
Stretch arc(Point2 centre, double radius, double from, double to);
/// Straight lines from corner to corner, closed.
std::vector<Stretch> polygon(const std::vector<Point2>& corners);
/// The same with the corners whose radius is positive rounded to it.
std::vector<Stretch> rounded_polygon(const std::vector<Point2>& corners, const std::vector<double>& radii);

/// Sweeps closed outlines, the first counter-clockwise around the others (holes, clockwise), along z from
/// `bottom` to `top`. `relief` is added to the height of the top and must be 0 along the outlines.
Shape extrusion(const std::vector<std::vector<Stretch>>& outlines, double bottom, double top, double edge,
                Random& random, const std::function<double(const Point2&)>& relief = {});

/// Turns a profile of (radius, height) around the z axis: from the axis at the bottom, counter-clockwise, to
/// the axis at the top. Flat discs and cones end on the axis; other stretches stay away from it.
Shape revolution(const std::vector<Stretch>& profile, double edge, Random& random);

/// The points p with dot(p, normal) <= distance for every plane; bounded, with no corner at more than three.
struct HalfSpace {
  Vec3d normal;  ///< unit
  double distance;
};
/// The outlines of its sides, counter-clockwise from outside; empty for planes that cut nothing.
std::vector<std::vector<Vec3d>> sides_of(const std::vector<HalfSpace>& planes);
Shape convex_solid(const std::vector<HalfSpace>& planes, double edge, Random& random);

}  // namespace burnish::testing
