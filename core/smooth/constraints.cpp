#include "core/smooth/constraints.h"

#include <algorithm>
#include <cmath>

#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Positions this many diagonals away have diverged; stopping here keeps every square and cube finite.
constexpr float kFarthest = 1e6F;

/// What writing a coordinate as text may add to a displacement, in local units: max_displacement holds in the
/// file.
constexpr double kTextSlack = 0x1p-22;

bool within_reach(std::span<const SimdVec3> positions) {  // false for NaN too
  using Lanes = SimdVec3::Lanes;
  auto fine = Lanes{} == Lanes{};
  for (const SimdVec3 p : positions) fine &= (p.lanes() <= kFarthest) & (p.lanes() >= -kFarthest);
  return (fine[0] & fine[1] & fine[2]) != 0;
}

/// The point on the way from `home` to `p` that is at most `limit` from home, after rounding to float.
Vec3f pull_back(const Vec3f& home, const Vec3f& p, double limit) {
  const Vec3d start = to_double(home), way = to_double(p) - start;
  const double distance = length(way);
  if (!(distance > limit)) return p;
  for (int share = 64; share > 32; --share) {  // in 64ths; rounding rarely needs the second
    const Vec3f near = to_float(start + way * (share * limit / (64 * distance)));
    if (length(to_double(near) - start) <= limit) return near;
  }
  return home;
}

Vec3d nearest_on_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d way = b - a;
  return a + way * std::clamp(dot(p - a, way) / dot(way, way), 0.0, 1.0);
}

Vec3d area_normal(std::span<const Vec3f> positions, const Triangle& t) {
  const Vec3d a = to_double(positions[t[0]]);
  return cross(to_double(positions[t[1]]) - a, to_double(positions[t[2]]) - a);
}

}  // namespace

Constraints::Constraints(const Surface& surface, const ConstraintOptions& options, const RunControl& run)
    : home_(surface.mesh.positions),
      movable_(home_.size()),
      limit_(std::max(0.0, options.max_displacement - kTextSlack)),
      limited_(options.max_displacement > 0) {
  int stays = kIsolatedVertex | kNonManifoldVertex;
  if (options.boundary == BoundaryRule::Fixed) stays |= kBoundaryVertex;
  parallel_for(movable_.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const bool pinned = !surface.pinned.empty() && surface.pinned[v] != 0;
      movable_[v] = !pinned && (surface.topology.vertex_flags[v] & stays) == 0;
    }
  });
  if (options.lock_features > 0) lock(surface, options.lock_features, run);
}

void Constraints::lock(const Surface& surface, double degrees, const RunControl& run) {
  rails_.assign(home_.size(), {kNone, kNone});
  std::vector<std::uint8_t> sharp_edges(home_.size());
  const auto add = [&](Index from, Index to) {
    if (sharp_edges[from] < 2) rails_[from][sharp_edges[from]] = to;
    if (sharp_edges[from] < 3) ++sharp_edges[from];
  };
  const auto& triangles = surface.mesh.triangles;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (t % kBlockSize == 0 && run.stopped()) return;
    for (std::size_t side = 0; side < 3; ++side) {
      const Index across = surface.topology.face_neighbours[t][side];
      if (across == kNone || across < t) continue;
      const Vec3d ours = area_normal(home_, triangles[t]);
      Vec3d theirs = area_normal(home_, triangles[across]);
      if (surface.topology.opposed(t, side)) theirs *= -1;
      if (portable_angle(length(cross(ours, theirs)), dot(ours, theirs)) * kDegreesPerRadian <= degrees)
        continue;
      const Index a = triangles[t][side], b = triangles[t][(side + 1) % 3];
      add(a, b);
      add(b, a);
    }
  }
  for (std::size_t v = 0; v < movable_.size(); ++v) {
    if (sharp_edges[v] == 1 || sharp_edges[v] > 2) movable_[v] = 0;
    if (sharp_edges[v] != 2) rails_[v] = {kNone, kNone};
  }
}

Vec3f Constraints::slide(std::size_t vertex, const Vec3f& p) const {
  const Vec3d home = to_double(home_[vertex]), wanted = to_double(p);
  const Vec3d first = nearest_on_segment(wanted, home, to_double(home_[rails_[vertex][0]]));
  const Vec3d second = nearest_on_segment(wanted, home, to_double(home_[rails_[vertex][1]]));
  const Vec3d a = wanted - first, b = wanted - second;
  return to_float(dot(a, a) <= dot(b, b) ? first : second);
}

bool Constraints::enforce(std::span<SimdVec3> to, std::size_t begin, std::size_t end) const {
  if (!within_reach(to.subspan(begin, end - begin))) return false;
  if (rails_.empty() && !limited_) return true;
  for (std::size_t v = begin; v < end; ++v) {
    if (movable_[v] == 0) continue;
    Vec3f p = to[v].vec3();
    if (!rails_.empty() && rails_[v][0] != kNone) p = slide(v, p);
    if (limited_) p = pull_back(home_[v], p, limit_);
    to[v] = SimdVec3(p);
  }
  return true;
}

}  // namespace burnish
