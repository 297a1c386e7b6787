#include "core/smooth/valence_order.h"

#include <algorithm>
#include <array>
#include <utility>

namespace burnish {

ValenceOrder::ValenceOrder(const Topology& topology, std::span<const std::uint8_t> movable, With with,
                           const RunControl& run)
    : block_size_(block_size(movable.size())), order_(movable.size()) {
  const auto group_of = [&](Index v) {
    const std::size_t valence = topology.vertex_neighbours[v].size();
    const bool regular = valence >= kLeast && valence <= kMost && !topology.has(v, kBoundaryVertex);
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

  const auto copy = [&](const IndexRows& from, Buffer<std::uint32_t>& to) {
    to.resize(rows);
    parallel_for(movable.size(), run, [&](std::size_t begin, std::size_t) {
      const std::size_t block = begin / block_size_;
      for (std::size_t g = first_group_[block]; g < first_group_[block + 1]; ++g) {
        const Range& range = groups_[g];
        std::uint32_t* row = to.data() + range.rows;
        with_constant_valence(range.valence, [&]<std::size_t kValence>() {
          for (std::size_t i = range.from; i < range.to; ++i, row += kValence) {
            const Index* const items = from.items.data() + from.offsets[order_[i]];
            for (std::size_t k = 0; k < kValence; ++k) row[k] = doubled(items[k]);
          }
        });
      }
    });
  };
  copy(topology.vertex_neighbours, neighbours_);
  if (with == With::NeighboursAndFaces) copy(topology.vertex_faces, faces_);
}

ValenceOrder::Group ValenceOrder::group(const Range& range) const {
  const std::size_t size = (range.to - range.from) * range.valence;
  const std::span<const std::uint32_t> neighbours = neighbours_, faces = faces_;
  return {range.valence, std::span(order_).subspan(range.from, range.to - range.from),
          neighbours.subspan(range.rows, size), faces.empty() ? faces : faces.subspan(range.rows, size)};
}

}  // namespace burnish
