#include "core/smooth/multigrid.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace burnish {
namespace {

/// Of Jacobi's step. A's eigenvalues over its diagonal's are at most 2, so anything below 1 converges.
constexpr float kDamping = 0.7F;
/// Levels end with so many rows, or where masses hold the rows that are left and Jacobi alone converges.
constexpr std::size_t kFewest = 16;
constexpr double kHeld = 0.5;
constexpr int kLastSteps = 8;  ///< of Jacobi on the last level

std::vector<float> damped(std::span<const float> diagonal) {
  std::vector<float> step(diagonal.size());
  std::ranges::transform(diagonal, step.begin(), [](float d) { return d > 0 ? kDamping / d : 0; });
  return step;
}

bool stopped_at(std::size_t row, const RunControl& run) { return row % kBlockSize == 0 && run.stopped(); }

}  // namespace

/// Joins each row to the free neighbour of the greatest weight, or to a pair; rows without any stay out.
bool Multigrid::join(const IndexRows& neighbours, std::span<const float> weights, std::vector<Index>& joined,
                     Index& count, const RunControl& run) {
  const std::size_t rows = neighbours.rows();
  joined.assign(rows, kNone);
  count = 0;
  for (Index v = 0; v < rows; ++v) {
    if (stopped_at(v, run)) return false;
    if (joined[v] != kNone) continue;
    float most_free = 0, most = 0;
    Index free = kNone, nearest = kNone;
    for (Index k = neighbours.offsets[v]; k < neighbours.offsets[v + 1]; ++k) {
      const Index w = neighbours.items[k];
      if (joined[w] == kNone && weights[k] > most_free) most_free = weights[k], free = w;
      if (weights[k] > most) most = weights[k], nearest = w;
    }
    if (nearest == kNone) continue;
    if (free != kNone && 2 * most_free >= most) {
      joined[v] = joined[free] = count++;
    } else if (joined[nearest] != kNone) {
      joined[v] = joined[nearest];
    } else {
      joined[v] = joined[free] = count++;
    }
  }
  return true;
}

/// The graph of the joined rows: weights add up, those within a row vanish.
bool Multigrid::shrink(const IndexRows& neighbours, std::span<const float> weights,
                       std::span<const float> hold, std::span<const Index> joined, Index count, float share,
                       Graph& to, const RunControl& run) {
  std::vector<Index> starts(count + 1), order(joined.size());
  for (const Index row : joined) {
    if (row != kNone) ++starts[row + 1];
  }
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  std::vector<Index> next(starts.begin(), starts.end() - 1);
  for (Index v = 0; v < joined.size(); ++v) {
    if (joined[v] != kNone) order[next[joined[v]]++] = v;
  }
  to.neighbours.offsets.assign(1, 0);
  to.neighbours.items.reserve(neighbours.items.size() / 2);
  to.weights.reserve(neighbours.items.size() / 2);
  to.hold.assign(count, 0);
  std::vector<Index> place(count, kNone);
  for (Index row = 0; row < count; ++row) {
    if (stopped_at(row, run)) return false;
    const std::size_t start = to.weights.size();
    for (Index i = starts[row]; i < starts[row + 1]; ++i) {
      const Index v = order[i];
      to.hold[row] += hold[v];
      for (Index k = neighbours.offsets[v]; k < neighbours.offsets[v + 1]; ++k) {
        const Index other = joined[neighbours.items[k]];
        if (other == kNone || other == row || weights[k] == 0) continue;
        if (place[other] == kNone || place[other] < start) {
          place[other] = static_cast<Index>(to.weights.size());
          to.neighbours.items.push_back(other);
          to.weights.push_back(0);
        }
        to.weights[place[other]] += weights[k] * share;
      }
    }
    to.neighbours.offsets.push_back(static_cast<Index>(to.weights.size()));
  }
  return true;
}

/// Pairs, and pairs of pairs.
bool Multigrid::coarsen(const IndexRows& neighbours, std::span<const float> weights,
                        std::span<const float> hold, Level& level, Graph& to, const RunControl& run) {
  Graph pairs;
  std::vector<Index> first, second;
  Index count = 0;
  if (!join(neighbours, weights, first, count, run) ||
      !shrink(neighbours, weights, hold, first, count, 1, pairs, run) ||
      !join(pairs.neighbours, pairs.weights, second, count, run) ||
      !shrink(pairs.neighbours, pairs.weights, pairs.hold, second, count, 0.5F, to, run)) {
    return false;
  }
  level.joined = std::move(first);
  level.members.offsets.assign(count + 1, 0);
  for (Index& row : level.joined) {
    if (row != kNone) row = second[row];
    if (row != kNone) ++level.members.offsets[row + 1];
  }
  std::vector<Index>& offsets = level.members.offsets;
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  level.members.items.resize(offsets.back());
  std::vector<Index> next(offsets.begin(), offsets.end() - 1);
  for (Index v = 0; v < level.joined.size(); ++v) {
    if (level.joined[v] != kNone) level.members.items[next[level.joined[v]]++] = v;
  }
  return true;
}

/// A level of a graph; its diagonal is what holds a row and the weights.
Multigrid::Level Multigrid::level_of(const Graph& graph) {
  const std::size_t rows = graph.hold.size();
  std::vector<float> diagonal = graph.hold;
  for (std::size_t v = 0; v < rows; ++v) {
    for (Index k = graph.neighbours.offsets[v]; k < graph.neighbours.offsets[v + 1]; ++k) {
      diagonal[v] += graph.weights[k];
    }
  }
  Level level{.rows = rows, .step = damped(diagonal)};
  level.b.resize(rows), level.x.resize(rows), level.rest.resize(rows);
  level.product = [&graph, diagonal = std::move(diagonal)](std::span<const SimdVec3> p, std::span<SimdVec3> q,
                                                           std::size_t begin) {
    const IndexRows& near = graph.neighbours;
    const std::size_t end = std::min(begin + block_size(q.size()), q.size());
    for (std::size_t v = begin; v < end; ++v) {
      SimdVec3 sum = p[v] * diagonal[v];
      for (Index k = near.offsets[v]; k < near.offsets[v + 1]; ++k)
        sum -= p[near.items[k]] * graph.weights[k];
      q[v] = sum;
    }
  };
  return level;
}

bool Multigrid::build(const IndexRows& neighbours, std::span<const float> weights,
                      std::span<const float> diagonal, Product product, const RunControl& run) {
  graphs_.clear();
  levels_.clear();
  // Weights to vertices that are no unknowns belong to what holds a row; they must join nothing.
  std::vector<float> inner(weights.begin(), weights.end()), hold(diagonal.begin(), diagonal.end());
  const bool done = for_each(diagonal.size(), run, [&](std::size_t v) {
    for (Index k = neighbours.offsets[v]; k < neighbours.offsets[v + 1]; ++k) {
      if (diagonal[v] == 0 || diagonal[neighbours.items[k]] == 0) inner[k] = 0;
      hold[v] -= inner[k];
    }
    hold[v] = std::max(hold[v], 0.0F);  // rounding
  });
  if (!done) return false;
  levels_.push_back({.rows = diagonal.size(), .product = std::move(product), .step = damped(diagonal)});
  levels_.back().rest.resize(diagonal.size());

  const IndexRows* near = &neighbours;
  std::span<const float> drawn = inner, held = hold;
  const auto sum = [](std::span<const float> of) { return std::accumulate(of.begin(), of.end(), 0.0); };
  while (held.size() > kFewest && sum(drawn) * kHeld > sum(held)) {
    Graph& to = *graphs_.emplace_back(std::make_unique<Graph>());
    if (!coarsen(*near, drawn, held, levels_.back(), to, run)) return false;
    levels_.push_back(level_of(to));
    near = &to.neighbours, drawn = to.weights, held = to.hold;
  }
  return true;
}

/// x += step (b - A x).
bool Multigrid::relax(Level& level, std::span<const SimdVec3> b, std::span<SimdVec3> x,
                      const RunControl& run) {
  return parallel_for(level.rows, run,
                      [&](std::size_t begin, std::size_t) { level.product(x, level.rest, begin); }) &&
         for_each(level.rows, run, [&](std::size_t v) { x[v] += (b[v] - level.rest[v]) * level.step[v]; });
}

bool Multigrid::cycle(std::size_t depth, std::span<const SimdVec3> b, std::span<SimdVec3> x,
                      const RunControl& run) {
  Level& level = levels_[depth];
  if (!for_each(level.rows, run, [&](std::size_t v) { x[v] = b[v] * level.step[v]; })) return false;
  if (depth + 1 == levels_.size()) {
    for (int i = 1; i < kLastSteps; ++i) {
      if (!relax(level, b, x, run)) return false;
    }
    return true;
  }
  Level& next = levels_[depth + 1];
  const bool down =
      parallel_for(level.rows, run,
                   [&](std::size_t begin, std::size_t) { level.product(x, level.rest, begin); }) &&
      for_each(next.rows, run, [&](std::size_t row) {
        SimdVec3 sum;
        for (const Index v : level.members[row]) sum += b[v] - level.rest[v];
        next.b[row] = sum;
      });
  return down && cycle(depth + 1, next.b, next.x, run) &&
         for_each(level.rows, run,
                  [&](std::size_t v) {
                    if (level.joined[v] != kNone) x[v] += next.x[level.joined[v]];
                  }) &&
         relax(level, b, x, run);
}

bool Multigrid::apply(std::span<const SimdVec3> r, std::span<SimdVec3> z, const RunControl& run) {
  return cycle(0, r, z, run);
}

}  // namespace burnish
