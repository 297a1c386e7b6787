#include "core/measure/quality.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

struct Totals {
  double area = 0, volume = 0, smallest_angle = 0;
};

/// Cotangent of the triangle's smallest angle: all three share the area, so the largest dot product has it.
double largest_cotangent(const Vec3d& a, const Vec3d& b, const Vec3d& c, double twice_area) {
  const double largest = std::max({dot(b - a, c - a), dot(c - b, a - b), dot(a - c, b - c)});
  return twice_area > 0 ? largest / twice_area : std::numeric_limits<double>::infinity();
}

Totals totals(const Surface& surface, std::span<const Vec3f> positions, const RunControl& run) {
  const auto& triangles = surface.mesh.triangles;
  const auto corner = [&](std::size_t t, std::size_t c) { return to_double(positions[triangles[t][c]]); };
  std::vector<double> cotangents(triangles.size());
  Totals result;
  result.area = parallel_sum(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
      const double twice_area = length(cross(b - a, c - a));
      sum += twice_area / 2;
      cotangents[t] = largest_cotangent(a, b, c, twice_area);
    }
    return sum;
  });
  result.volume = parallel_sum(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t t = begin; t < end; ++t) sum += dot(corner(t, 0), cross(corner(t, 1), corner(t, 2))) / 6;
    return sum;
  });
  if (!cotangents.empty()) {
    result.smallest_angle = portable_angle(1, *std::max_element(cotangents.begin(), cotangents.end()));
  }
  return result;
}

/// Below `negligible` the value before is only rounding, and a percentage of it would mean nothing.
double percent(double before, double after, double negligible) {
  return std::abs(before) > negligible ? 100 * (after - before) / std::abs(before) : 0;
}

}  // namespace

Result<MeshChange> measure_change(const Surface& surface, std::span<const Vec3f> before,
                                  std::span<const Vec3f> after, const RunControl& run) {
  MeshChange change;
  std::vector<double> squared(before.size());
  const double sum = parallel_sum(before.size(), run, [&](std::size_t begin, std::size_t end) {
    double block = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3d way = to_double(after[v]) - to_double(before[v]);
      block += squared[v] = dot(way, way);
    }
    return block;
  });
  const std::size_t counted = before.size() - surface.topology.isolated_vertices;
  const double scale = surface.mesh.frame.scale();
  if (counted > 0) change.rms_displacement = std::sqrt(sum / static_cast<double>(counted)) * scale;
  if (!squared.empty()) {
    change.max_displacement = std::sqrt(*std::max_element(squared.begin(), squared.end())) * scale;
  }
  const Totals was = totals(surface, before, run), is = totals(surface, after, run);
  if (run.stopped()) return run.stop_error();
  change.area_percent = percent(was.area, is.area, 0);
  change.volume_percent = percent(was.volume, is.volume, 1e-9 * was.area);
  change.smallest_angle_before = was.smallest_angle * kDegreesPerRadian;
  change.smallest_angle_after = is.smallest_angle * kDegreesPerRadian;
  return change;
}

}  // namespace burnish
