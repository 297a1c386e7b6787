#include "core/mesh/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/mesh/order.h"
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

std::uint64_t mix(std::uint64_t x) {  // spreads every bit, so grids do not collide
  x = (x ^ (x >> 32)) * 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 29)) * 0xbf58476d1ce4e5b9U;
  return x ^ (x >> 32);
}

std::uint64_t hash_position(const Vec3d& p) {
  // Adding zero turns -0 into +0, which compares equal and must hash equal.
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value + 0.0); };
  return mix(bits(p.x) + std::rotl(bits(p.y) * 0x9fb21c651e98df25U, 21) +
             std::rotl(bits(p.z) * 0xd6e8feb86659fd93U, 43));
}

/// First item equal to each item: an open-addressing table, because std::unordered_map takes ten times as
/// long.
template <class Equal>
class FirstEqual {
 public:
  FirstEqual(std::size_t items, Equal equal) : slots_(std::bit_ceil(items * 2 + 2), kNone), equal_(equal) {}

  /// Tells the cache which slot will be asked for soon: large tables wait for memory otherwise.
  void expect(std::uint64_t hash) const { __builtin_prefetch(&slots_[hash & (slots_.size() - 1)], 1); }

  Index find_or_add(Index item, std::uint64_t hash) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = hash & mask;; slot = (slot + 1) & mask) {
      if (slots_[slot] == kNone) return slots_[slot] = item;
      if (equal_(slots_[slot], item)) return slots_[slot];
    }
  }

 private:
  std::vector<Index> slots_;
  Equal equal_;
};

/// first[i] = the first item that equals item i. The tasks share the items out by their hashes, so each item
/// meets its equals in one table, in the order of one thread.
template <class Hash, class Equal>
bool find_first_equals(std::size_t items, const RunControl& run, std::vector<Index>& first, Hash hash,
                       Equal equal) {
  constexpr std::size_t kMostTasks = 8, kWorthATask = 32 * kBlockSize;
  const std::size_t tasks =
      std::clamp<std::size_t>(items / kWorthATask, 1, std::min(kMostTasks, thread_count(run)));
  first.resize(items);
  return parallel_tasks(tasks, run, [&](std::size_t task) {
    FirstEqual table(items / tasks, equal);
    constexpr std::size_t kAhead = 64;
    std::uint64_t hashes[kAhead];
    Index numbers[kAhead];
    for (std::size_t begin = 0; begin < items; begin += kAhead) {
      if (begin % kBlockSize == 0 && run.stopped()) return;
      std::size_t count = 0;
      for (std::size_t i = begin; i < std::min(items, begin + kAhead); ++i) {
        numbers[count] = static_cast<Index>(i);
        hashes[count] = hash(i);
        const bool own = tasks == 1 || (hashes[count] >> 32) * tasks >> 32 == task;
        if (own) table.expect(hashes[count]);
        count += own;
      }
      for (std::size_t k = 0; k < count; ++k) first[numbers[k]] = table.find_or_add(numbers[k], hashes[k]);
    }
  });
}

/// Fills weld and the welded vertices' file indices.
bool weld_positions(std::span<const Vec3d> positions, std::span<const Index> parts, const RunControl& run,
                    Surface& surface, std::vector<Index>& kept) {
  std::vector<Index>& weld = surface.weld;  // the first equal vertex, then where that went
  const auto equal = [&](Index a, Index b) { return positions[a] == positions[b]; };
  const bool found = parts.empty()
                         ? find_first_equals(
                               positions.size(), run, weld,
                               [&](std::size_t v) { return hash_position(positions[v]); }, equal)
                         : find_first_equals(
                               positions.size(), run, weld,
                               [&](std::size_t v) { return mix(hash_position(positions[v]) + parts[v]); },
                               [&](Index a, Index b) { return parts[a] == parts[b] && equal(a, b); });
  if (!found) return false;
  kept.reserve(positions.size());
  return for_each(positions.size(), run.on_one_thread(), [&](std::size_t v) {
    if (weld[v] == v) {
      weld[v] = static_cast<Index>(kept.size());
      kept.push_back(static_cast<Index>(v));
    } else {
      weld[v] = weld[weld[v]];
      ++surface.welded_vertices;
    }
  });
}

Triangle sorted(Triangle t) {
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  if (t[1] > t[2]) std::swap(t[1], t[2]);
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  return t;
}

/// Takes over the triangles that have three corners after welding.
bool keep_triangles(std::span<const Triangle> triangles, const RunControl& run, Surface& surface) {
  std::vector<Triangle>& kept = surface.mesh.triangles;
  std::vector<Index>& source = surface.source_triangle;
  kept.resize(triangles.size());
  source.resize(triangles.size());
  std::vector<std::uint32_t> degenerate(block_count(triangles.size()), 0);
  const bool done = parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    std::uint32_t count = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [a, b, c] = triangles[i];
      const Triangle t{surface.weld[a], surface.weld[b], surface.weld[c]};
      kept[i] = t;
      source[i] = static_cast<Index>(i);
      count += static_cast<std::uint32_t>(t[0] == t[1] || t[1] == t[2] || t[2] == t[0]);
    }
    degenerate[begin / block_size(triangles.size())] = count;
  });
  if (!done) return false;
  surface.degenerate_triangles = std::accumulate(degenerate.begin(), degenerate.end(), std::uint32_t{0});
  if (surface.degenerate_triangles == 0) return true;
  std::size_t count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Triangle t = kept[i];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
      kept[count] = t;
      source[count++] = static_cast<Index>(i);
    } else if (surface.first_degenerate == kNone) {
      surface.first_degenerate = static_cast<Index>(i);
    }
  }
  kept.resize(count);
  source.resize(count);
  return true;
}

/// Leaves out triangles whose corners an earlier one has.
bool drop_repeated_triangles(const RunControl& run, Surface& surface) {
  std::vector<Triangle>& kept = surface.mesh.triangles;
  std::vector<Index>&source = surface.source_triangle, first;
  const bool found = find_first_equals(
      kept.size(), run, first,
      [&](std::size_t t) {
        const Triangle s = sorted(kept[t]);
        return mix(mix(std::uint64_t{s[0]} << 32 | s[1]) + s[2]);
      },
      [&](Index a, Index b) { return sorted(kept[a]) == sorted(kept[b]); });
  if (!found) return false;
  std::size_t count = 0;
  for (std::size_t t = 0; t < kept.size(); ++t) {
    if (first[t] == t) {
      kept[count] = kept[t];
      source[count++] = source[t];
    } else {
      ++surface.duplicate_triangles;
      surface.first_duplicate = std::min(surface.first_duplicate, source[t]);
    }
  }
  kept.resize(count);
  source.resize(count);
  return true;
}

/// Repeated triangles are rare, and the topology sees them in passing: only then are they looked for and is
/// it built again.
Result<> connect(std::size_t vertices, const RunControl& run, Surface& surface) {
  for (;;) {
    auto topology = build_topology(vertices, surface.mesh.triangles, run);
    if (!topology) return topology.error();
    surface.topology = std::move(*topology);
    if (!surface.topology.repeated_triangles) return {};
    if (!drop_repeated_triangles(run, surface)) return run.stop_error();
  }
}

}  // namespace

Result<Surface> prepare_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                const RunControl& run, std::span<const Index> parts) {
  Surface surface;
  std::vector<Index> kept;
  if (!weld_positions(positions, parts, run, surface, kept) || !keep_triangles(triangles, run, surface)) {
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
  if (!order_for_cache(surface, run)) return run.stop_error();
  if (auto connected = connect(kept.size(), run, surface); !connected) return connected.error();
  surface.mean_edge = mean_edge_length(surface.mesh.positions, surface.topology, run);
  if (run.stopped()) return run.stop_error();
  return surface;
}

}  // namespace burnish
