#include "core/mesh/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/run/parallel.h"

namespace burnish {
namespace {

struct Box {
  Vec3d low, high;
};

Box bounding_box(std::span<const Vec3d> positions) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const Vec3d& p : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], p[axis]);
      box.high[axis] = std::max(box.high[axis], p[axis]);
    }
  }
  return box;
}

Frame frame_around(std::span<const Vec3d> positions) {
  const Box box = bounding_box(positions);
  const double diagonal = length(box.high - box.low);
  Frame frame{box.low + (box.high - box.low) * 0.5, diagonal > 0 ? std::ilogb(diagonal) : 0};
  // Halves of the smallest doubles could round; such models keep their own origin and unit.
  if (frame.exponent < -900) frame = {};
  return frame;
}

std::uint64_t mix(std::uint64_t x) {  // splitmix64: spreads every bit, so grids do not collide
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

std::uint64_t hash_position(const Vec3d& p) {
  // Adding zero turns -0 into +0, which compares equal and must hash equal.
  std::uint64_t h = mix(std::bit_cast<std::uint64_t>(p.x + 0.0));
  h = mix(h ^ std::bit_cast<std::uint64_t>(p.y + 0.0));
  return mix(h ^ std::bit_cast<std::uint64_t>(p.z + 0.0));
}

/// First item equal to each item: an open-addressing table, because std::unordered_map takes ten times as
/// long.
template <class Hash, class Equal>
class FirstEqual {
 public:
  FirstEqual(std::size_t items, Hash hash, Equal equal)
      : slots_(std::bit_ceil(items * 2 + 2), kNone), hash_(hash), equal_(equal) {}

  Index find_or_add(Index item) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = hash_(item) & mask;; slot = (slot + 1) & mask) {
      if (slots_[slot] == kNone) return slots_[slot] = item;
      if (equal_(slots_[slot], item)) return slots_[slot];
    }
  }

 private:
  std::vector<Index> slots_;
  Hash hash_;
  Equal equal_;
};

/// Fills weld and the welded vertices' file indices.
bool weld_positions(std::span<const Vec3d> positions, const RunControl& run, Surface& surface,
                    std::vector<Index>& kept) {
  FirstEqual first(
      positions.size(), [&](Index v) { return hash_position(positions[v]); },
      [&](Index a, Index b) { return positions[a] == positions[b]; });
  surface.weld.resize(positions.size());
  kept.reserve(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i % kBlockSize == 0 && run.stopped()) return false;
    const Index v = static_cast<Index>(i);
    const Index same = first.find_or_add(v);
    if (same == v) {
      surface.weld[v] = static_cast<Index>(kept.size());
      kept.push_back(v);
    } else {
      surface.weld[v] = surface.weld[same];
      ++surface.welded_vertices;
    }
  }
  return true;
}

Triangle sorted(Triangle t) {
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  if (t[1] > t[2]) std::swap(t[1], t[2]);
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  return t;
}

bool keep_triangles(std::span<const Triangle> triangles, const RunControl& run, Surface& surface) {
  std::vector<Triangle>& kept = surface.mesh.triangles;
  kept.reserve(triangles.size());
  surface.source_triangle.reserve(triangles.size());
  FirstEqual first(
      triangles.size(),
      [&](Index t) {
        const Triangle s = sorted(kept[t]);
        return mix(mix((std::uint64_t{s[0]} << 32) | s[1]) ^ s[2]);
      },
      [&](Index a, Index b) { return sorted(kept[a]) == sorted(kept[b]); });
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (i % kBlockSize == 0 && run.stopped()) return false;
    const Triangle t{surface.weld[triangles[i][0]], surface.weld[triangles[i][1]],
                     surface.weld[triangles[i][2]]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      if (surface.degenerate_triangles++ == 0) surface.first_degenerate = static_cast<Index>(i);
      continue;
    }
    const Index candidate = static_cast<Index>(kept.size());
    kept.push_back(t);
    if (first.find_or_add(candidate) != candidate) {
      kept.pop_back();
      if (surface.duplicate_triangles++ == 0) surface.first_duplicate = static_cast<Index>(i);
      continue;
    }
    surface.source_triangle.push_back(static_cast<Index>(i));
  }
  return true;
}

}  // namespace

Result<Surface> prepare_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                const RunControl& run) {
  Surface surface;
  std::vector<Index> kept;
  if (!weld_positions(positions, run, surface, kept) || !keep_triangles(triangles, run, surface)) {
    return run.stop_error();
  }
  surface.mesh.frame = frame_around(positions);
  surface.mesh.positions.resize(kept.size());
  const bool done = parallel_for(kept.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      surface.mesh.positions[v] = surface.mesh.frame.to_local(positions[kept[v]]);
    }
  });
  if (!done) return run.stop_error();
  auto topology = build_topology(kept.size(), surface.mesh.triangles, run);
  if (!topology) return topology.error();
  surface.topology = std::move(*topology);
  surface.mean_edge = mean_edge_length(surface.mesh.positions, surface.topology, run);
  if (run.stopped()) return run.stop_error();
  return surface;
}

}  // namespace burnish
