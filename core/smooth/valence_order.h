// The order in which a pass visits vertices: within each block of the parallel loops, those with the same
// number of neighbours together. A loop over neighbours then runs with a fixed count, and the processor,
// which cannot guess when a loop over five, six or seven ends, no longer has to
// (docs/decisions/0009-order-of-work.md).
#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/mesh/topology.h"
#include "core/run/buffer.h"
#include "core/run/parallel.h"

namespace burnish {

class ValenceOrder {
 public:
  /// Smallest and largest valence with a group of its own.
  static constexpr std::size_t kLeast = 3, kMost = 10;
  /// "Valence" of the group that holds all others: on the rim of a surface or where several meet, or with
  /// fewer or more neighbours.
  static constexpr std::size_t kOther = 0;

  struct Group {
    std::size_t valence;              ///< neighbours, and triangles, at each of its vertices; or kOther
    std::span<const Index> vertices;  ///< ascending
    /// Neighbours of one vertex after the other, `valence` each, as doubled(); empty for kOther.
    std::span<const std::uint32_t> neighbours;
    /// With rings: the neighbours come in the order in which the triangles at the vertex go round it, and
    /// here is, for each and the next, the third corner of the triangle across the edge between the two; the
    /// neighbour itself where there is none.
    std::span<const std::uint32_t> beyond;
  };

  /// Only movable vertices are in it. When `run` stops it half-way, its groups mean nothing.
  ValenceOrder(const Topology& topology, std::span<const std::uint8_t> movable, const RunControl& run = {});
  /// With rings.
  ValenceOrder(std::span<const Triangle> triangles, const Topology& topology,
               std::span<const std::uint8_t> movable, const RunControl& run = {});

  /// Calls visit(group) for the block of vertices that starts at `begin`, as parallel_for hands it out.
  template <class Visit>
  void for_each_group(std::size_t begin, Visit&& visit) const {
    const std::size_t block = begin / block_size_;
    for (std::size_t g = first_group_[block]; g < first_group_[block + 1]; ++g) visit(group(groups_[g]));
  }

 private:
  struct Range {
    std::size_t valence, from, to;  ///< vertices
    std::size_t rows;               ///< where their neighbours begin
  };
  Group group(const Range& range) const;
  /// Everything but the neighbours; returns how many there will be.
  std::size_t sort(const Topology& topology, std::span<const std::uint8_t> movable, const RunControl& run);
  /// Calls fill.template operator()<valence>(vertices, row) for every group but kOther's, in parallel, with
  /// the place of its first neighbour.
  template <class Fill>
  void fill_rows(const RunControl& run, Fill&& fill) const;

  std::size_t block_size_;  ///< of the loops over vertices
  Buffer<Index> order_;
  std::vector<Range> groups_;
  std::vector<std::size_t> first_group_;  ///< per block, and the end
  Buffer<std::uint32_t> neighbours_, beyond_;
};

/// A doubled index finds an element of 16 bytes without a shift: processors scale an address by 8 for
/// nothing.
inline std::uint32_t doubled(Index index) { return 2 * index; }
template <class Item>
Item& at_doubled(Item* items, std::uint32_t index) {
  static_assert(sizeof(Item) == 16);
  using Byte = std::conditional_t<std::is_const_v<Item>, const char, char>;
  return *reinterpret_cast<Item*>(reinterpret_cast<Byte*>(items) + std::size_t{8} * index);
}

/// From so many vertices on, whose positions leave the caches between two iterations, fetch_ahead() pays.
constexpr bool pays_to_fetch_ahead(std::size_t vertices) { return vertices > std::size_t{1} << 18; }

/// Asks for what the next blocks will read and write: the order by valence and the neighbours beyond a
/// block's rim are no pattern that the processor would guess.
inline void fetch_ahead(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t v) {
  __builtin_prefetch(from.data() + v + 2 * kBlockSize);
  __builtin_prefetch(to.data() + v + kBlockSize);
}

/// Calls body.template operator()<valence>() with the group's valence as a constant.
template <class Body>
void with_constant_valence(std::size_t valence, Body&& body) {
  switch (valence) {
    case 3:
      return body.template operator()<3>();
    case 4:
      return body.template operator()<4>();
    case 5:
      return body.template operator()<5>();
    case 6:
      return body.template operator()<6>();
    case 7:
      return body.template operator()<7>();
    case 8:
      return body.template operator()<8>();
    case 9:
      return body.template operator()<9>();
    case 10:
      return body.template operator()<10>();
    default:
      return;
  }
}

}  // namespace burnish
