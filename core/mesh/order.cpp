#include "core/mesh/order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/mesh/curve.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Up to here everything fits the caches in any order.
constexpr std::size_t kSmall = 8192;
/// Mean distance in memory, in vertices, that is still near.
constexpr double kNear = 1024;

/// How far a pass over the triangles jumps: within them, and from each to the next.
double mean_jump(std::span<const Triangle> triangles, const RunControl& run) {
  const auto lowest = [](const Triangle& t) { return std::min(std::min(t[0], t[1]), t[2]); };
  if (triangles.empty()) return 0;
  // One triangle in eight tells as well: the first of every stretch.
  constexpr std::size_t kStretch = 512, kAsked = 64;
  const auto asked = [&](std::size_t stretch) {
    const std::size_t begin = stretch * kStretch;
    return triangles.subspan(begin, std::min(kAsked, triangles.size() - begin));
  };
  const std::size_t stretches = (triangles.size() + kStretch - 1) / kStretch;
  const double sum = parallel_sum(stretches, run, [&](std::size_t begin, std::size_t end) {
    std::uint64_t jumps = 0;
    for (std::size_t stretch = begin; stretch < end; ++stretch) {
      Index last = lowest(asked(stretch).front());
      for (const Triangle& t : asked(stretch)) {
        const Index low = lowest(t), high = std::max(std::max(t[0], t[1]), t[2]);
        jumps += std::uint64_t{high - low} + (std::max(low, last) - std::min(low, last));
        last = low;
      }
    }
    return static_cast<double>(jumps);
  });
  const std::size_t last = stretches - 1;
  return sum / static_cast<double>(last * kAsked + asked(last).size());
}

template <class Item>
bool permute(std::vector<Item>& items, std::span<const Index> order, const RunControl& run) {
  std::vector<Item> moved(items.size());
  const bool done = for_each(order.size(), run, [&](std::size_t i) { moved[i] = items[order[i]]; });
  items = std::move(moved);
  return done;
}

/// Triangles by their lowest vertex, by counting. Cut short when stopped.
std::vector<Index> by_first_vertex(std::span<const Triangle> triangles, std::size_t vertices,
                                   const RunControl& run) {
  std::vector<Index> starts(vertices + 1), order(triangles.size());
  const auto first = [&](std::size_t t) {
    const auto [a, b, c] = triangles[t];
    return std::min(std::min(a, b), c);
  };
  const auto alone = run.on_one_thread();
  for_each(triangles.size(), alone, [&](std::size_t t) { ++starts[first(t) + 1]; });
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  for_each(triangles.size(), alone,
           [&](std::size_t t) { order[starts[first(t)]++] = static_cast<Index>(t); });
  return order;
}

}  // namespace

bool order_for_cache(Surface& surface, const RunControl& run) {
  Mesh& mesh = surface.mesh;
  if (mesh.positions.size() <= kSmall || mean_jump(mesh.triangles, run) <= kNear) return !run.stopped();
  const auto order = curve_order(mesh.positions, run);
  if (run.stopped()) return false;
  std::vector<Index> place(order.size());
  if (!for_each(order.size(), run, [&](std::size_t i) { place[order[i]] = static_cast<Index>(i); }) ||
      !permute(mesh.positions, order, run) ||
      !for_each(surface.weld.size(), run, [&](std::size_t v) { surface.weld[v] = place[surface.weld[v]]; }) ||
      !for_each(mesh.triangles.size(), run, [&](std::size_t i) {
        Triangle& t = mesh.triangles[i];
        t = {place[t[0]], place[t[1]], place[t[2]]};
      })) {
    return false;
  }
  const auto triangles = by_first_vertex(mesh.triangles, mesh.positions.size(), run);
  return !run.stopped() && permute(mesh.triangles, triangles, run) &&
         permute(surface.source_triangle, triangles, run);
}

}  // namespace burnish
