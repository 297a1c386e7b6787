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
double mean_jump(std::span<const Triangle> triangles) {
  std::uint64_t sum = 0;
  Index last = 0;
  for (const auto [a, b, c] : triangles) {
    const Index low = std::min(std::min(a, b), c), high = std::max(std::max(a, b), c);
    sum += std::uint64_t{high - low} + (std::max(low, last) - std::min(low, last));
    last = low;
  }
  return static_cast<double>(sum) / static_cast<double>(triangles.size());
}

template <class Item>
void permute(std::vector<Item>& items, std::span<const Index> order) {
  std::vector<Item> moved(items.size());
  for (std::size_t i = 0; i < order.size(); ++i) moved[i] = items[order[i]];
  items = std::move(moved);
}

/// Triangles by their lowest vertex, by counting.
std::vector<Index> by_first_vertex(std::span<const Triangle> triangles, std::size_t vertices) {
  std::vector<Index> starts(vertices + 1), order(triangles.size());
  const auto first = [&](std::size_t t) {
    const auto [a, b, c] = triangles[t];
    return std::min(std::min(a, b), c);
  };
  for (std::size_t t = 0; t < triangles.size(); ++t) ++starts[first(t) + 1];
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  for (std::size_t t = 0; t < triangles.size(); ++t) order[starts[first(t)]++] = static_cast<Index>(t);
  return order;
}

}  // namespace

bool order_for_cache(Surface& surface, const RunControl& run) {
  Mesh& mesh = surface.mesh;
  if (mesh.positions.size() <= kSmall || mean_jump(mesh.triangles) <= kNear) return !run.stopped();
  const auto order = curve_order(mesh.positions, run);
  if (run.stopped()) return false;
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<Index>(i);
  permute(mesh.positions, order);
  for (Index& v : surface.weld) v = place[v];
  for (Triangle& t : mesh.triangles) t = {place[t[0]], place[t[1]], place[t[2]]};
  if (run.stopped()) return false;
  const auto triangles = by_first_vertex(mesh.triangles, mesh.positions.size());
  permute(mesh.triangles, triangles);
  permute(surface.source_triangle, triangles);
  return !run.stopped();
}

}  // namespace burnish
