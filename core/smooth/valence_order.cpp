#include "core/smooth/valence_order.h"

#include <algorithm>
#include <array>
#include <utility>

namespace burnish {

ValenceOrder::ValenceOrder(const Topology& topology, std::span<const std::uint8_t> movable, With with,
                           const RunControl& run)
    : order_(movable.size()) {
  const auto group_of = [&](Index v) {
    const std::size_t valence = topology.vertex_neighbours[v].size();
    const bool regular = valence >= kLeast && valence <= kMost && !topology.has(v, kBoundaryVertex);
    return regular ? valence : kOther;
  };
  const std::size_t blocks = (movable.size() + kBlockSize - 1) / kBlockSize;
  std::vector<std::array<std::uint32_t, kMost + 1>> next(blocks);  // how many of each valence, then where
  parallel_for(movable.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (movable[v] != 0) ++next[begin / kBlockSize][group_of(static_cast<Index>(v))];
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
    for (std::size_t v = begin; v < end; ++v) {
      if (movable[v] != 0) {
        order_[next[begin / kBlockSize][group_of(static_cast<Index>(v))]++] = static_cast<Index>(v);
      }
    }
  });

  const auto copy = [&](const IndexRows& from, Buffer<std::uint32_t>& to) {
    to.resize(rows);
    parallel_for(movable.size(), run, [&](std::size_t begin, std::size_t) {
      const std::size_t block = begin / kBlockSize;
      for (std::size_t g = first_group_[block]; g < first_group_[block + 1]; ++g) {
        const Range& range = groups_[g];
        std::uint32_t* row = to.data() + range.rows;
        for (std::size_t i = range.from; i < range.to && range.valence != kOther; ++i, row += range.valence) {
          std::ranges::transform(from[order_[i]], row, doubled);
        }
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
