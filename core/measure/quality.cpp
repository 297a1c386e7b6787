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

/// The cotangent of a triangle's smallest angle as a fraction: the largest dot product of two sides over
/// their cross product, which all three angles share.
struct Cotangent {
  double dot = 0, cross = 1;
  bool operator<(const Cotangent& b) const { return dot * b.cross < b.dot * cross; }
};

constexpr Cotangent kNoAngle{1, 0};

Totals totals(const Surface& surface, std::span<const Vec3f> positions, const RunControl& run) {
  const auto& triangles = surface.mesh.triangles;
  struct Block {
    double volume = 0;
    Cotangent sharpest;
  };
  std::vector<Block> blocks(triangles.size() / kBlockSize + 1);
  Totals result;
  result.area = parallel_sum(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    double area = 0;
    Block block;
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3d a = to_double(positions[triangles[t][0]]), b = to_double(positions[triangles[t][1]]),
                  c = to_double(positions[triangles[t][2]]);
      const Vec3d ab = b - a, bc = c - b, ca = a - c;
      const double twice_area = length(cross(ab, bc));
      area += twice_area / 2;
      block.volume += dot(a, cross(b, c)) / 6;
      const double largest_dot = -std::min(std::min(dot(ab, ca), dot(ab, bc)), dot(bc, ca));
      block.sharpest =
          std::max(block.sharpest, twice_area > 0 ? Cotangent{largest_dot, twice_area} : kNoAngle);
    }
    blocks[begin / kBlockSize] = block;
    return area;
  });
  Cotangent sharpest;
  for (const Block& block : blocks) {
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
  std::vector<double> largest(before.size() / kBlockSize + 1, 0);
  const double sum = parallel_sum(before.size(), run, [&](std::size_t begin, std::size_t end) {
    double block = 0, farthest = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3d way = to_double(after[v]) - to_double(before[v]);
      const double squared = dot(way, way);
      block += squared;
      farthest = std::max(farthest, squared);
    }
    largest[begin / kBlockSize] = farthest;
    return block;
  });
  const std::size_t counted = before.size() - surface.topology.isolated_vertices;
  const double scale = surface.mesh.frame.scale();
  if (counted > 0) change.rms_displacement = std::sqrt(sum / static_cast<double>(counted)) * scale;
  change.max_displacement = std::sqrt(std::ranges::max(largest)) * scale;
  const Totals was = totals(surface, before, run), is = totals(surface, after, run);
  if (run.stopped()) return run.stop_error();
  change.area_percent = percent(was.area, is.area, 0);
  change.volume_percent = percent(was.volume, is.volume, 1e-9 * was.area);
  change.smallest_angle_before = was.smallest_angle * kDegreesPerRadian;
  change.smallest_angle_after = is.smallest_angle * kDegreesPerRadian;
  return change;
}

}  // namespace burnish
