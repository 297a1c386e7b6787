#include "core/measure/quality.h"

#include <algorithm>
#include <cmath>

#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

struct Totals {
  double area = 0, volume = 0, smallest_angle = 0;
};

double smallest_angle_of(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double twice_area = length(cross(b - a, c - a));
  return std::min({portable_angle(twice_area, dot(b - a, c - a)),
                   portable_angle(twice_area, dot(c - b, a - b)),
                   portable_angle(twice_area, dot(a - c, b - c))});
}

Totals totals(const Surface& surface, std::span<const Vec3f> positions, const RunControl& run) {
  const auto& triangles = surface.mesh.triangles;
  const auto corner = [&](std::size_t t, std::size_t c) { return to_double(positions[triangles[t][c]]); };
  std::vector<double> smallest(triangles.size());
  Totals result;
  result.area = parallel_sum(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t t = begin; t < end; ++t) {
      sum += length(cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0))) / 2;
      smallest[t] = smallest_angle_of(corner(t, 0), corner(t, 1), corner(t, 2));
    }
    return sum;
  });
  result.volume = parallel_sum(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t t = begin; t < end; ++t) sum += dot(corner(t, 0), cross(corner(t, 1), corner(t, 2))) / 6;
    return sum;
  });
  if (!smallest.empty()) result.smallest_angle = *std::min_element(smallest.begin(), smallest.end());
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
