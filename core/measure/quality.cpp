#include "core/measure/quality.h"

#include <algorithm>
#include <cmath>

#include "core/measure/triangle_sums.h"
#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

struct Totals {
  double area = 0, volume = 0, smallest_angle = 0;
};

Totals totals(const Surface& surface, std::span<const Vec3f> positions, const RunControl& run) {
  const std::span triangles(surface.mesh.triangles);
  std::vector<triangle_sums::Shape> blocks(block_count(triangles.size()));
  parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    blocks[begin / block_size(triangles.size())] =
        triangle_sums::functions().shape(triangles.subspan(begin, end - begin), positions);
  });
  Totals result;
  triangle_sums::Cotangent sharpest;
  for (const auto& block : blocks) {
    result.area += block.area;
    result.volume += block.volume;
    sharpest = std::max(sharpest, block.sharpest);
  }
  if (!triangles.empty()) result.smallest_angle = portable_angle(sharpest.cross, sharpest.dot);
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
  std::vector<double> largest(block_count(before.size()), 0);
  const double sum = parallel_sum(before.size(), run, [&](std::size_t begin, std::size_t end) {
    double block = 0, farthest = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3d way = to_double(after[v]) - to_double(before[v]);
      const double squared = dot(way, way);
      block += squared;
      farthest = std::max(farthest, squared);
    }
    largest[begin / block_size(before.size())] = farthest;
    return block;
  });
  const std::size_t counted = before.size() - surface.topology.isolated_vertices;
  const double scale = surface.mesh.frame.scale();
  if (counted > 0) change.rms_displacement = std::sqrt(sum / static_cast<double>(counted)) * scale;
  const double farthest = largest.empty() ? 0 : std::ranges::max(largest);
  change.max_displacement = std::sqrt(farthest) * scale;
  const Totals was = totals(surface, before, run), is = totals(surface, after, run);
  if (run.stopped()) return run.stop_error();
  change.area_percent = percent(was.area, is.area, 0);
  change.volume_percent = percent(was.volume, is.volume, 1e-9 * was.area);
  change.smallest_angle_before = was.smallest_angle * kDegreesPerRadian;
  change.smallest_angle_after = is.smallest_angle * kDegreesPerRadian;
  return change;
}

}  // namespace burnish
