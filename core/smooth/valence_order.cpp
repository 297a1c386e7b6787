#include "core/smooth/valence_order.h"

#include <algorithm>
#include <array>
#include <utility>

namespace burnish {
namespace {

// No branch here depends on how a triangle is turned, which no processor guesses.
/// The corner that follows a corner in a triangle, or the side across from it.
std::size_t after(const Triangle& t, Index corner) {
  return static_cast<std::size_t>(t[0] == corner) + 2 * static_cast<std::size_t>(t[1] == corner);
}
/// The third corner.
Index beside(const Triangle& t, Index a, Index b) { return t[0] ^ t[1] ^ t[2] ^ a ^ b; }

/// The neighbours of vertices inside the surface, one triangle after the other, and what lies beyond. Each
/// step waits for the one before: a few vertices at once keep the processor busy.
template <std::size_t kValence, std::size_t kAtOnce>
void walk_round(std::span<const Triangle> triangles, const Topology& topology, const Index* vertices,
                std::uint32_t* ring, std::uint32_t* beyond) {
  Index faces[kAtOnce], neighbours[kAtOnce];
  for (std::size_t k = 0; k < kAtOnce; ++k) {
    faces[k] = topology.vertex_faces[vertices[k]].front();
    neighbours[k] = triangles[faces[k]][after(triangles[faces[k]], vertices[k])];
  }
  for (std::size_t i = 0; i < kValence; ++i) {
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const Index vertex = vertices[k], here = neighbours[k];
      const Triangle &t = triangles[faces[k]], &across = topology.face_neighbours[faces[k]];
      const Index there = beside(t, vertex, here), far = across[after(t, vertex)];
      ring[k * kValence + i] = doubled(here);
      beyond[k * kValence + i] = doubled(far == kNone ? here : beside(triangles[far], here, there));
      faces[k] = across[after(t, here)];
      neighbours[k] = there;
    }
  }
}

}  // namespace

ValenceOrder::ValenceOrder(const Topology& topology, std::span<const std::uint8_t> movable,
                           const RunControl& run)
    : block_size_(block_size(movable.size())), order_(movable.size()) {
  neighbours_.resize(sort(topology, movable, run));
  const IndexRows& from = topology.vertex_neighbours;
  fill_rows(run, [&]<std::size_t kValence>(std::span<const Index> vertices, std::size_t row) {
    for (const Index v : vertices) {
      const Index* const items = from.items.data() + from.offsets[v];
      for (std::size_t k = 0; k < kValence; ++k) neighbours_[row++] = doubled(items[k]);
    }
  });
}

ValenceOrder::ValenceOrder(std::span<const Triangle> triangles, const Topology& topology,
                           std::span<const std::uint8_t> movable, const RunControl& run)
    : block_size_(block_size(movable.size())), order_(movable.size()) {
  neighbours_.resize(sort(topology, movable, run));
  beyond_.resize(neighbours_.size());
  fill_rows(run, [&]<std::size_t kValence>(std::span<const Index> vertices, std::size_t row) {
    constexpr std::size_t kAtOnce = 4;
    std::size_t i = 0;
    const auto walk = [&]<std::size_t kCount>() {
      const std::size_t at = row + i * kValence;
      walk_round<kValence, kCount>(triangles, topology, &vertices[i], &neighbours_[at], &beyond_[at]);
      i += kCount;
    };
    while (i + kAtOnce <= vertices.size()) walk.template operator()<kAtOnce>();
    while (i < vertices.size()) walk.template operator()<1>();
  });
}

std::size_t ValenceOrder::sort(const Topology& topology, std::span<const std::uint8_t> movable,
                               const RunControl& run) {
  const auto group_of = [&](Index v) {
    const std::size_t valence = topology.vertex_neighbours[v].size();
    const bool regular = valence >= kLeast && valence <= kMost && topology.vertex_flags[v] == 0;
    return regular ? valence : kOther;
  };
  const std::size_t blocks = block_count(movable.size());
  std::vector<std::array<std::uint32_t, kMost + 1>> next(blocks);  // how many of each valence, then where
  parallel_for(movable.size(), run, [&](std::size_t begin, std::size_t end) {
    auto& counts = next[begin / block_size_];
    for (std::size_t v = begin; v < end; ++v) {
      if (movable[v] != 0) ++counts[group_of(static_cast<Index>(v))];
    }
  });
  std::size_t placed = 0, rows = 0;
  for (auto& of_block : next) {
    first_group_.push_back(groups_.size());
    for (std::size_t valence = 0; valence < of_block.size(); ++valence) {
      const std::size_t count = std::exchange(of_block[valence], static_cast<std::uint32_t>(placed));
      if (count > 0) groups_.push_back({valence, placed, placed + count, rows});
      placed += count;
      rows += count * valence;
    }
  }
  first_group_.push_back(groups_.size());
  parallel_for(movable.size(), run, [&](std::size_t begin, std::size_t end) {
    auto& places = next[begin / block_size_];
    for (std::size_t v = begin; v < end; ++v) {
      if (movable[v] != 0) order_[places[group_of(static_cast<Index>(v))]++] = static_cast<Index>(v);
    }
  });
  return run.stopped() ? 0 : rows;
}

template <class Fill>
void ValenceOrder::fill_rows(const RunControl& run, Fill&& fill) const {
  parallel_for(order_.size(), run, [&](std::size_t begin, std::size_t) {
    const std::size_t block = begin / block_size_;
    for (std::size_t g = first_group_[block]; g < first_group_[block + 1]; ++g) {
      const Range& range = groups_[g];
      with_constant_valence(range.valence, [&]<std::size_t kValence>() {
        fill.template operator()<kValence>(group(range).vertices, range.rows);
      });
    }
  });
}

ValenceOrder::Group ValenceOrder::group(const Range& range) const {
  const std::size_t size = (range.to - range.from) * range.valence;
  const std::span<const std::uint32_t> neighbours = neighbours_, beyond = beyond_;
  return {range.valence, std::span(order_).subspan(range.from, range.to - range.from),
          neighbours.subspan(range.rows, size), beyond.empty() ? beyond : beyond.subspan(range.rows, size)};
}

}  // namespace burnish
