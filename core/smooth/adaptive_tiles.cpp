#include "core/smooth/adaptive_tiles.h"

#include "core/smooth/adaptive_kernels.h"

namespace burnish {
namespace {

class Builder {
 public:
  Builder(std::span<const Triangle> triangles, const Topology& topology, const ValenceOrder& order)
      : triangles_(triangles), topology_(topology), order_(order), place_(triangles.size(), kNone) {}

  AdaptiveTiles::Tile build(std::size_t begin) {
    AdaptiveTiles::Tile tile;
    count_ = 0;
    add_faces(begin, tile);
    fill_up();
    add_neighbours(tile);
    fill_up();
    finish(tile);
    return tile;
  }

 private:
  /// Room for so many more triangles, and to fill up.
  void reserve(std::size_t more) {
    const std::size_t needed = count_ + more + adaptive_kernels::kTrianglesAtOnce;
    if (listed_.size() < needed) listed_.resize(needed);
  }

  /// Number of triangle f, the next one if it has none yet. A branch would be mispredicted for a third of the
  /// triangles at a vertex.
  std::uint32_t number_of(Index f) {
    const Index known = place_[f];
    const bool is_new = known == kNone;
    const Index number = is_new ? static_cast<Index>(count_) : known;
    listed_[count_] = f;
    place_[f] = number;
    count_ += is_new ? 1 : 0;
    return number;
  }

  void fill_up() {
    while (count_ % adaptive_kernels::kTrianglesAtOnce != 0) listed_[count_++] = kNone;
  }

  void add_faces(std::size_t begin, AdaptiveTiles::Tile& tile) {
    std::size_t size = 0;
    order_.for_each_group(begin, [&](const ValenceOrder::Group& group) {
      for (const Index v : group.vertices) size += topology_.vertex_faces[v].size();
    });
    tile.faces.resize(size);
    reserve(size);
    std::uint32_t* to = tile.faces.data();
    order_.for_each_group(begin, [&](const ValenceOrder::Group& group) {
      for (const Index v : group.vertices) {
        for (const Index f : topology_.vertex_faces[v]) *to++ = doubled(number_of(f));
      }
    });
  }

  /// Undoubled, kNone and the highest bit still stand for no neighbour and a turned one.
  void add_neighbours(AdaptiveTiles::Tile& tile) {
    const std::size_t expected = count_;
    tile.across.resize(3 * expected);
    reserve(3 * expected);
    for (std::size_t i = 0; i < expected; ++i) {
      const Index f = listed_[i];
      for (std::size_t side = 0; side < 3; ++side) {
        const Index n = f == kNone ? kNone : topology_.face_neighbours[f][side];
        std::uint32_t& to = tile.across[3 * i + side];
        to = n == kNone ? kNone : number_of(n);
        if (n == kNone || !topology_.opposed(f, side)) continue;
        to |= kTurned;
        tile.any_turned = true;
      }
    }
  }

  void finish(AdaptiveTiles::Tile& tile) {
    tile.corners.resize(3 * count_);
    for (std::uint32_t& row : tile.across) {
      const std::size_t number = row == kNone           ? tile.none()
                                 : (row & kTurned) != 0 ? tile.turned(row & ~kTurned)
                                                        : row;
      row = doubled(static_cast<Index>(number));
    }
    for (std::size_t i = 0; i < count_; ++i) {
      const Index f = listed_[i];
      for (std::size_t c = 0; c < 3; ++c)
        tile.corners[3 * i + c] = f == kNone ? 0 : doubled(triangles_[f][c]);
      if (f != kNone) place_[f] = kNone;
    }
  }

  static constexpr std::uint32_t kTurned = std::uint32_t{1} << 31;

  std::span<const Triangle> triangles_;
  const Topology& topology_;
  const ValenceOrder& order_;
  std::vector<Index> place_;  ///< number in the tile of each triangle, kNone between tiles
  Buffer<Index> listed_;      ///< the tile's triangles, `count_` of them
  std::size_t count_ = 0;
};

}  // namespace

AdaptiveTiles::AdaptiveTiles(std::span<const Triangle> triangles, const Topology& topology,
                             const ValenceOrder& order, const RunControl& run)
    : block_size_(block_size(topology.vertex_flags.size())),
      tiles_(block_count(topology.vertex_flags.size())) {
  const std::size_t tasks = std::min(tiles_.size(), thread_count(run));
  parallel_tasks(tasks, run, [&](std::size_t task) {
    Builder builder(triangles, topology, order);
    const std::size_t end = (task + 1) * tiles_.size() / tasks;
    for (std::size_t t = task * tiles_.size() / tasks; t < end && !run.stopped(); ++t) {
      tiles_[t] = builder.build(t * block_size_);
    }
  });
}

}  // namespace burnish
