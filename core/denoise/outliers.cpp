#include "core/denoise/outliers.h"

#include <algorithm>
#include <cmath>

namespace burnish {
namespace {

constexpr float kNormalMedian = 0.67449F;  // of the absolute value of a normal variable
constexpr float kAboveNear = 1.75F, kAboveAll = 0.5F;
constexpr float kTails = 1.9F;
constexpr std::size_t kCrowd = 64;

/// 0 of none.
float spread_of(std::vector<float>& moves) {
  if (moves.empty()) return 0;
  const auto middle = moves.begin() + static_cast<std::ptrdiff_t>(moves.size() / 2);
  std::ranges::nth_element(moves, middle);
  return *middle / kNormalMedian;
}

/// The vertices within two rings of v, each once, without v.
void two_rings(const Topology& topology, std::size_t v, std::vector<Index>& near) {
  const auto add = [&](std::span<const Index> row) {
    if (row.size() <= kCrowd) near.insert(near.end(), row.begin(), row.end());
  };
  near.clear();
  add(topology.vertex_neighbours[v]);
  for (std::size_t i = 0, first = near.size(); i < first; ++i) add(topology.vertex_neighbours[near[i]]);
  std::ranges::sort(near);
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::erase(near, static_cast<Index>(v));
}

}  // namespace

bool find_outliers(const Topology& topology, std::span<const std::uint8_t> movable,
                   std::span<const float> moves, std::span<std::uint8_t> outlier, const RunControl& run) {
  std::vector<float> all;
  double squares = 0;
  for (std::size_t v = 0; v < moves.size(); ++v) {
    outlier[v] = 0;
    if (movable[v] == 0) continue;
    all.push_back(moves[v]);
    squares += static_cast<double>(moves[v]) * static_cast<double>(moves[v]);
  }
  const float spread = spread_of(all);
  if (!(squares > static_cast<double>(kTails * spread * kTails * spread) * static_cast<double>(all.size()))) {
    return false;
  }
  parallel_for(moves.size(), run, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> near;
    std::vector<float> around;
    for (std::size_t v = begin; v < end; ++v) {
      if (movable[v] == 0 || moves[v] <= kAboveNear * kAboveAll * spread) continue;
      two_rings(topology, v, near);
      around.clear();
      for (const Index w : near) {
        if (movable[w] != 0) around.push_back(moves[w]);
      }
      outlier[v] = moves[v] > kAboveNear * spread_of(around) ? 1 : 0;
    }
  });
  return true;
}

}  // namespace burnish
