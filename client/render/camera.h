// Where a mesh is looked at from. Parallel projection: lengths across the view are true.
#pragma once

#include <cstdint>
#include <span>

#include "core/mesh/mesh.h"

namespace burnish::render {

enum class UpAxis : std::uint8_t { Y, Z };

struct View {
  double azimuth = 30;    ///< degrees to the right of the front, which is +z, or -y when z is up
  double elevation = 20;  ///< degrees above the horizon, -90 to 90
  UpAxis up = UpAxis::Y;
  double zoom = 1;  ///< 1: all of the mesh fits
};

/// Three unit vectors at right angles: what is right and up in the picture, and where the eye is.
struct Axes {
  Vec3d right, up, eye;
};
Axes axes_of(const View& view);

/// What of space a picture shows, in its own coordinates; grows to hold points.
struct Extent {
  double left = 0, right = 0, bottom = 0, top = 0, back = 0, front = 0;
  bool empty = true;

  void add(const Axes& axes, std::span<const Vec3d> points);
  Vec3d centre(const Axes& axes) const;  ///< in space
  double radius() const;                 ///< half of the diagonal
};

/// Pixels and points: the extent's middle is the middle of a cell of `width` by `height` pixels.
struct Camera {
  Axes axes;
  Vec3d centre = {};             ///< in space
  double radius = 1;             ///< of what there is to see, which is the unit of the rays
  double pixel = 1;              ///< width of a pixel in radii
  double width = 0, height = 0;  ///< pixels

  /// Point of the picture's plane through the centre, in radii from there; pixels from the top left corner.
  Vec3d at(double x, double y) const {
    return axes.right * ((x - width / 2) * pixel) + axes.up * ((height / 2 - y) * pixel);
  }
};

/// `margin`: share of the smaller side that stays free all around.
Camera look_at(const View& view, const Extent& extent, unsigned width, unsigned height, double margin);

}  // namespace burnish::render
