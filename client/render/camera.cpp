#include "client/render/camera.h"

#include <algorithm>

#include "core/run/math.h"

namespace burnish::render {
namespace {

double cosine(double degrees) { return portable_cos(degrees / kDegreesPerRadian); }
double sine(double degrees) { return cosine(degrees - 90); }

Vec3d unit(const Vec3d& v) { return v * (1 / length(v)); }

}  // namespace

Axes axes_of(const View& view) {
  const bool z_up = view.up == UpAxis::Z;
  const double across = sine(view.azimuth), along = cosine(view.azimuth);
  const double level = cosine(view.elevation), height = sine(view.elevation);
  Axes axes;
  axes.right = z_up ? Vec3d{along, across, 0} : Vec3d{along, 0, -across};
  axes.eye = unit(z_up ? Vec3d{across * level, -along * level, height}
                       : Vec3d{across * level, height, along * level});
  axes.up = cross(axes.eye, axes.right);
  return axes;
}

void Extent::add(const Axes& axes, std::span<const Vec3d> points) {
  for (const Vec3d& p : points) {
    const double x = dot(p, axes.right), y = dot(p, axes.up), z = dot(p, axes.eye);
    left = empty ? x : std::min(left, x), right = empty ? x : std::max(right, x);
    bottom = empty ? y : std::min(bottom, y), top = empty ? y : std::max(top, y);
    back = empty ? z : std::min(back, z), front = empty ? z : std::max(front, z);
    empty = false;
  }
}

Vec3d Extent::centre(const Axes& axes) const {
  return axes.right * ((left + right) / 2) + axes.up * ((bottom + top) / 2) + axes.eye * ((back + front) / 2);
}

double Extent::radius() const { return length(Vec3d{right - left, top - bottom, front - back}) / 2; }

Camera look_at(const View& view, const Extent& extent, unsigned width, unsigned height, double margin) {
  Camera camera{.axes = axes_of(view), .width = double(width), .height = double(height)};
  camera.centre = extent.centre(camera.axes);
  camera.radius = extent.radius() > 0 ? extent.radius() : 1;
  const double free = 2 * margin * std::min(camera.width, camera.height);
  const double across = (extent.right - extent.left) / std::max(camera.width - free, 1.0);
  const double upward = (extent.top - extent.bottom) / std::max(camera.height - free, 1.0);
  const double widest = std::max(across, upward);
  camera.pixel = widest > 0 ? widest / camera.radius / view.zoom : 1;
  return camera;
}

}  // namespace burnish::render
