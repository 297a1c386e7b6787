#include "core/smooth/volume.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/run/parallel.h"

namespace burnish {
namespace {

/// The components' numbers, by vertex; isolated vertices are components of their own.
struct Components {
  std::vector<Index> of_vertex;
  std::size_t count = 0;

  explicit Components(const Surface& surface) : of_vertex(surface.mesh.positions.size()) {
    std::iota(of_vertex.begin(), of_vertex.end(), Index{0});
    for (const Triangle& t : surface.mesh.triangles) {
      join(t[0], t[1]);
      join(t[0], t[2]);
    }
    for (std::size_t v = 0; v < of_vertex.size(); ++v) {  // a root is never above its members
      of_vertex[v] = of_vertex[v] == v ? static_cast<Index>(count++) : of_vertex[of_vertex[v]];
    }
  }

 private:
  Index root(Index v) {
    while (of_vertex[v] != v) v = of_vertex[v] = of_vertex[of_vertex[v]];
    return v;
  }
  void join(Index a, Index b) {
    a = root(a), b = root(b);
    of_vertex[std::max(a, b)] = std::min(a, b);
  }
};

/// No body of its diagonal, below 2 in local units, has more volume than the ball of half of it as radius: no
/// offset need be larger, not even from a point.
constexpr double kLargestOffset = 1;

/// What one component needs to find its offset.
struct Balance {
  double wanted = 0;            ///< volume of the input
  double tolerance = 0;         ///< how near is near enough
  double area = 0;              ///< of what may move: the slope of the volume over the offset
  double offset = 0, next = 0;  ///< tried, to try; equal when there is nothing more to try
  double off = 0;               ///< volume at `offset` minus `wanted`
  double best = 0, best_off = 0;

  void start(double volume, double target, double mean_edge) {
    wanted = target;
    tolerance = 1e-6 * (std::abs(wanted) + area * mean_edge);
    off = best_off = volume - wanted;
    if (area > 0 && std::abs(off) > tolerance)
      next = std::clamp(-off / area, -kLargestOffset, kLargestOffset);
  }

  /// A secant step towards no difference.
  void improve(double volume) {
    if (next == offset) return;
    const double now = volume - wanted, slope = (now - off) / (next - offset);
    offset = next;
    off = now;
    if (std::abs(off) < std::abs(best_off)) best = offset, best_off = off;
    if (std::abs(off) > tolerance && slope > 0.01 * area) {
      next = std::clamp(offset - off / slope, -kLargestOffset, kLargestOffset);
    }
  }
};

class Restorer {
 public:
  Restorer(const Surface& surface, const Constraints& constraints, const RunControl& run)
      : surface_(surface), constraints_(constraints), run_(run), components_(surface) {}

  bool restore(std::span<SimdVec3> positions, std::vector<Warning>& warnings) {
    const std::vector<SimdVec3> home(surface_.mesh.positions.begin(), surface_.mesh.positions.end());
    smoothed_.assign(positions.begin(), positions.end());
    balances_.resize(components_.count);
    const auto wanted = volumes(home), is = volumes(positions);
    measure_normals();
    for (std::size_t c = 0; c < balances_.size(); ++c) {
      balances_[c].start(is[c], wanted[c], surface_.mean_edge);
    }
    constexpr int kMostTries = 20;  // a few do, but for what has nearly vanished
    for (int i = 0; i < kMostTries && !run_.stopped() && !settled(); ++i) {
      place(positions, &Balance::next);
      const auto tried = volumes(positions);
      for (std::size_t c = 0; c < balances_.size(); ++c) balances_[c].improve(tried[c]);
    }
    place(positions, &Balance::best);
    warn(warnings);
    return !run_.stopped();
  }

 private:
  /// Volume of each component, closed.
  std::vector<double> volumes(std::span<const SimdVec3> positions) const {
    const auto at = [&](Index v) { return to_double(positions[v].vec3()); };
    const auto& triangles = surface_.mesh.triangles;
    const std::vector<Vec3d> caps = cap_centres(positions);
    std::vector<double> of_triangle(triangles.size()), sums(components_.count);
    parallel_for(triangles.size(), run_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Vec3d corners[3] = {at(triangles[t][0]), at(triangles[t][1]), at(triangles[t][2])};
        double six = dot(corners[0], cross(corners[1], corners[2]));
        for (std::size_t side = 0; side < 3; ++side) {
          if (surface_.topology.face_neighbours[t][side] != kNone) continue;
          const Vec3d& centre = caps[components_.of_vertex[triangles[t][0]]];
          six += dot(corners[(side + 1) % 3], cross(corners[side], centre));
        }
        of_triangle[t] = six / 6;
      }
    });
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      sums[components_.of_vertex[triangles[t][0]]] += of_triangle[t];
    }
    return sums;
  }

  std::vector<Vec3d> cap_centres(std::span<const SimdVec3> positions) const {
    std::vector<Vec3d> centres(components_.count);
    std::vector<double> counts(components_.count);
    for (Index v = 0; v < positions.size(); ++v) {
      if (!surface_.topology.has(v, kBoundaryVertex)) continue;
      centres[components_.of_vertex[v]] += to_double(positions[v].vec3());
      ++counts[components_.of_vertex[v]];
    }
    for (std::size_t c = 0; c < centres.size(); ++c) {
      if (counts[c] > 0) centres[c] *= 1 / counts[c];
    }
    return centres;
  }

  /// Unit normals of the smoothed mesh where vertices may move, and how much area follows them.
  void measure_normals() {
    normals_.assign(smoothed_.size(), {});
    for (std::size_t v = 0; v < smoothed_.size(); ++v) {
      if (constraints_.movable()[v] == 0) continue;
      SimdVec3 sum;
      for (const Index f : surface_.topology.vertex_faces[v]) {
        const auto [a, b, c] = surface_.mesh.triangles[f];
        sum += cross(smoothed_[b] - smoothed_[a], smoothed_[c] - smoothed_[a]);
      }
      const float size = length(sum);
      if (!(size > 0)) continue;
      normals_[v] = sum * (1 / size);
      balances_[components_.of_vertex[v]].area += static_cast<double>(size) / 6;  // d volume = a third of it
    }
  }

  void place(std::span<SimdVec3> positions, double Balance::*offset) const {
    parallel_for(positions.size(), run_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const double by = balances_[components_.of_vertex[v]].*offset;
        if (constraints_.movable()[v] != 0)
          positions[v] = smoothed_[v] + normals_[v] * static_cast<float>(by);
      }
      constraints_.enforce(positions, begin, end);
    });
  }

  bool settled() const {
    return std::ranges::all_of(balances_, [](const Balance& b) { return b.next == b.offset; });
  }

  void warn(std::vector<Warning>& warnings) const {
    const auto lost = std::ranges::count_if(
        balances_, [](const Balance& b) { return std::abs(b.best_off) > 10 * b.tolerance; });
    if (lost == 0) return;
    warnings.push_back({"volume_not_kept",
                        "the volume of a component could not be restored: it has collapsed, or its vertices "
                        "may not move that far",
                        static_cast<std::uint32_t>(lost)});
  }

  const Surface& surface_;
  const Constraints& constraints_;
  const RunControl& run_;
  Components components_;
  std::vector<SimdVec3> smoothed_, normals_;
  std::vector<Balance> balances_;
};

}  // namespace

bool restore_volume(const Surface& surface, const Constraints& constraints, std::span<SimdVec3> positions,
                    const RunControl& run, std::vector<Warning>& warnings) {
  return Restorer(surface, constraints, run).restore(positions, warnings);
}

}  // namespace burnish
