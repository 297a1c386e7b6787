#include "core/mesh/topology.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Turns counts per row (in offsets[row + 1]) into offsets.
void counts_to_offsets(std::vector<Index>& offsets) {
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
}

/// Counting sort. Each task reads all triangles and keeps to a range of vertices of its own, so no two write
/// to one place and the order is that of one thread.
bool faces_at_vertices(std::size_t vertices, std::span<const Triangle> triangles, const RunControl& run,
                       IndexRows& rows) {
  constexpr std::size_t kMostTasks = 8, kWorthATask = 32 * kBlockSize;
  const std::size_t tasks =
      std::clamp<std::size_t>(triangles.size() / kWorthATask, 1, std::min(kMostTasks, thread_count(run)));
  rows.offsets.assign(vertices + 1, 0);
  rows.items.resize(triangles.size() * 3);
  const auto for_each_corner = [&](std::size_t task, auto&& visit) {
    const std::size_t low = vertices * task / tasks, size = vertices * (task + 1) / tasks - low;
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      if (f % kBlockSize == 0 && run.stopped()) return;
      for (const Index v : triangles[f]) {
        if (tasks == 1 || v - low < size) visit(v, static_cast<Index>(f));
      }
    }
  };
  const bool counted = parallel_tasks(tasks, run, [&](std::size_t task) {
    for_each_corner(task, [&](Index v, Index) { ++rows.offsets[v + 1]; });
  });
  if (!counted) return false;
  counts_to_offsets(rows.offsets);
  std::vector<Index> next(rows.offsets.begin(), rows.offsets.end() - 1);
  return parallel_tasks(tasks, run, [&](std::size_t task) {
    for_each_corner(task, [&](Index v, Index f) { rows.items[next[v]++] = f; });
  });
}

/// What a block of vertices found out about its edges, each of which is seen from both of its ends.
struct BlockOfStars {
  std::vector<Index> neighbours;  // the rows of the block's vertices
  std::uint32_t boundary_edges = 0, non_manifold_edges = 0, opposed_edges = 0;
  std::uint32_t non_manifold_vertices = 0, isolated_vertices = 0;
  bool repeated_triangles = false;
};

/// The triangles around one vertex after another: lists its neighbours and links the triangles across the
/// edges that leave it, so that every side of every triangle is written once.
class StarLinker {
 public:
  StarLinker(std::span<const Triangle> triangles, Topology& topology, BlockOfStars& block)
      : triangles_(triangles), topology_(topology), block_(block) {}

  void link(Index vertex) {
    const auto faces = topology_.vertex_faces[vertex];
    if (link_plain(vertex, faces)) return;
    if (faces.empty()) {
      topology_.vertex_flags[vertex] = kIsolatedVertex;
      ++block_.isolated_vertices;
    } else {
      link_any(vertex, faces);
    }
  }

 private:
  using Lanes =
      std::int32_t __attribute__((vector_size(16)));  // what every x86-64 and ARM64 computes at once

  /// The triangle (vertex, next, last), turned so that it starts at the vertex.
  struct Corner {
    std::uint8_t side;  // that leaves the vertex
    Index next, last;
  };
  static Corner corner_at(Index vertex, const Triangle& t) {
    constexpr std::uint8_t kNext[] = {1, 2, 0, 0}, kLast[] = {2, 0, 1, 0};  // no triangle gives side 3
    const auto side = static_cast<std::uint8_t>((t[1] == vertex) + 2 * (t[2] == vertex));
    return {side, t[kNext[side]], t[kLast[side]]};
  }

  /// The star of nearly every vertex: one closed fan of few triangles that wind the same way. False, and
  /// nothing is written, when it is another.
  bool link_plain(Index vertex, std::span<const Index> faces) {
    switch (faces.size()) {
      case 3:
        return link_fan<3>(vertex, faces.data());
      case 4:
        return link_fan<4>(vertex, faces.data());
      case 5:
        return link_fan<5>(vertex, faces.data());
      case 6:
        return link_fan<6>(vertex, faces.data());
      case 7:
        return link_fan<7>(vertex, faces.data());
      case 8:
        return link_fan<8>(vertex, faces.data());
      default:
        return false;
    }
  }

  /// No branch depends on the order of the triangles, which is as good as random.
  template <std::size_t kCount>
  bool link_fan(Index vertex, const Index* faces) {
    constexpr std::size_t kRows = (kCount + 3) / 4;
    constexpr Index kFlip = Index{1} << 31;  // makes the order of indices that of signed numbers
    std::array<std::int32_t, 4 * kRows> next{}, last{}, odd, rank, across;
    std::array<std::uint8_t, kCount> side;
    for (std::size_t i = 0; i < kCount; ++i) {
      const Corner corner = corner_at(vertex, triangles_[faces[i]]);
      next[i] = static_cast<std::int32_t>(corner.next ^ kFlip);
      last[i] = static_cast<std::int32_t>(corner.last ^ kFlip);
      side[i] = corner.side;
    }
    for (std::size_t row = 0; row < kRows; ++row) {
      Lanes nexts, less{}, same{}, mates{}, mate{};
      std::memcpy(&nexts, &next[4 * row], sizeof nexts);
      for (std::size_t i = 0; i < kCount; ++i) {
        const Lanes meets = nexts == last[i];
        less -= nexts > next[i];
        same -= nexts == next[i];
        mates -= meets;
        mate |= meets & static_cast<std::int32_t>(i);
      }
      const Lanes wrong = (same ^ 1) | (mates ^ 1);
      std::memcpy(&rank[4 * row], &less, sizeof less);  // its place among the sorted
      std::memcpy(&across[4 * row], &mate,
                  sizeof mate);  // the triangle that arrives from where this one leaves to
      std::memcpy(&odd[4 * row], &wrong,
                  sizeof wrong);  // not 0 unless there is one such triangle, and no twin
    }
    std::int32_t any_odd = 0;
    for (std::size_t i = 0; i < kCount; ++i) any_odd |= odd[i];
    if (any_odd != 0) return false;
    auto at = static_cast<std::size_t>(across[0]);
    for (std::size_t i = 1; i < kCount; ++i) {
      if (at == 0) return false;  // round already: there are two fans
      at = static_cast<std::size_t>(across[at]);
    }
    const std::size_t first = block_.neighbours.size();
    block_.neighbours.resize(first + kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      block_.neighbours[first + static_cast<std::size_t>(rank[i])] = static_cast<Index>(next[i]) ^ kFlip;
      topology_.face_neighbours[faces[i]][side[i]] = faces[across[i]];
    }
    topology_.vertex_flags[vertex] = 0;
    return true;
  }

  /// One of the two edges of a triangle at the vertex. Number 2i leaves the vertex in triangle i of the star,
  /// number 2i + 1 arrives there.
  struct Spoke {
    Index other, number, third;
    bool operator<(const Spoke& b) const { return other != b.other ? other < b.other : number < b.number; }
  };

  void link_any(Index vertex, std::span<const Index> faces) {
    spokes_.clear();
    sides_.clear();
    mates_.assign(2 * faces.size(), kNone);
    for (Index i = 0; i < faces.size(); ++i) {
      const Corner corner = corner_at(vertex, triangles_[faces[i]]);
      spokes_.push_back({corner.next, 2 * i, corner.last});
      spokes_.push_back({corner.last, 2 * i + 1, corner.next});
      sides_.push_back(corner.side);
    }
    std::sort(spokes_.begin(), spokes_.end());
    std::uint8_t flags = 0;
    for (std::size_t i = 0, j = 0; i < spokes_.size(); i = j) {
      while (++j < spokes_.size() && spokes_[j].other == spokes_[i].other) {
      }
      flags |= link_edge(std::span(spokes_).subspan(i, j - i));
    }
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const Index mate = mates_[2 * i];
      topology_.face_neighbours[faces[i]][sides_[i]] = mate == kNone ? kNone : faces[mate / 2];
    }
    if ((flags & kNonManifoldVertex) == 0 && fan_size() != faces.size()) flags |= kNonManifoldVertex;
    topology_.vertex_flags[vertex] = flags;
    block_.non_manifold_vertices += (flags & kNonManifoldVertex) != 0;
  }

  /// The flag that the edge with these uses gives its ends.
  std::uint8_t link_edge(std::span<Spoke> uses) {
    block_.neighbours.push_back(uses[0].other);
    if (uses.size() == 1) {
      ++block_.boundary_edges;
      return kBoundaryVertex;
    }
    std::sort(uses.begin(), uses.end(), [](const Spoke& a, const Spoke& b) { return a.third < b.third; });
    for (std::size_t i = 1; i < uses.size(); ++i) {
      block_.repeated_triangles |= uses[i].third == uses[i - 1].third;
    }
    if (uses.size() > 2) {
      ++block_.non_manifold_edges;
      return kNonManifoldVertex;
    }
    mates_[uses[0].number] = uses[1].number;
    mates_[uses[1].number] = uses[0].number;
    block_.opposed_edges += uses[0].number % 2 == uses[1].number % 2;
    return 0;
  }

  /// Triangles reached from the first one by walking across shared edges, in both directions.
  std::size_t fan_size() const {
    std::size_t reached = 1;
    for (const std::size_t direction : {0, 1}) {
      for (Index at = mates_[direction]; at != kNone; at = mates_[at ^ 1]) {
        if (at / 2 == 0) return reached;  // all the way round
        ++reached;
      }
    }
    return reached;
  }

  std::span<const Triangle> triangles_;
  Topology& topology_;
  BlockOfStars& block_;
  std::vector<Spoke> spokes_;
  std::vector<std::uint8_t> sides_;
  std::vector<Index> mates_;  // per spoke the one that shares its edge, when it is the only one
};

bool link_stars(std::span<const Triangle> triangles, const RunControl& run, Topology& topology) {
  const std::size_t vertices = topology.vertex_flags.size();
  std::vector<BlockOfStars> blocks(block_count(vertices));
  IndexRows& rows = topology.vertex_neighbours;
  rows.offsets.assign(vertices + 1, 0);
  const bool linked = parallel_for(vertices, run, [&](std::size_t begin, std::size_t end) {
    BlockOfStars& block = blocks[begin / block_size(vertices)];
    StarLinker linker(triangles, topology, block);
    block.neighbours.reserve(7 * kBlockSize);
    for (std::size_t v = begin; v < end; ++v) {
      linker.link(static_cast<Index>(v));
      rows.offsets[v + 1] = static_cast<Index>(block.neighbours.size());
    }
  });
  if (!linked) return false;
  std::vector<Index> firsts;
  Index ends_of_edges = 0;
  for (const BlockOfStars& block : blocks) {
    firsts.push_back(ends_of_edges);
    ends_of_edges += static_cast<Index>(block.neighbours.size());
    topology.boundary_edges += block.boundary_edges;
    topology.non_manifold_edges += block.non_manifold_edges;
    topology.opposed_edges += block.opposed_edges;
    topology.non_manifold_vertices += block.non_manifold_vertices;
    topology.isolated_vertices += block.isolated_vertices;
    topology.repeated_triangles |= block.repeated_triangles;
  }
  rows.items.resize(ends_of_edges);
  topology.edges = ends_of_edges / 2;
  topology.boundary_edges /= 2;
  topology.non_manifold_edges /= 2;
  topology.opposed_edges /= 2;
  return parallel_for(vertices, run, [&](std::size_t begin, std::size_t end) {
    const std::size_t b = begin / block_size(vertices);
    std::copy(blocks[b].neighbours.begin(), blocks[b].neighbours.end(), rows.items.begin() + firsts[b]);
    for (std::size_t v = begin; v < end; ++v) rows.offsets[v + 1] += firsts[b];
  });
}

/// Marks neighbours that run along their shared edge in the same direction.
bool mark_opposed(std::span<const Triangle> triangles, const RunControl& run, Topology& topology) {
  topology.opposed_neighbours.assign(triangles.size(), 0);
  return parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      for (std::size_t e = 0; e < 3; ++e) {
        const Index across = topology.face_neighbours[f][e];
        if (across == kNone) continue;
        const Triangle& theirs = triangles[across];
        const Index from = triangles[f][e], to = triangles[f][(e + 1) % 3];
        const std::size_t at = theirs[0] == from ? 0 : theirs[1] == from ? 1 : 2;
        if (theirs[(at + 1) % 3] == to) topology.opposed_neighbours[f] |= static_cast<std::uint8_t>(1U << e);
      }
    }
  });
}

/// Follows each vertex down its smallest neighbours to a root, then joins the trees that meet: first around
/// the roots, which leaves one or a few, then wherever a triangle connects two. When one is left the rest
/// needs no look.
std::uint32_t count_components(std::span<const Triangle> triangles, const Topology& topology,
                               const RunControl& run) {
  const std::size_t vertices = topology.vertex_flags.size();
  std::vector<Index> parent(vertices), roots;
  for_each(vertices, run.on_one_thread(), [&](std::size_t v) {
    const auto row = topology.vertex_neighbours[v];
    const bool root = row.empty() || row.front() > v;
    parent[v] = root ? static_cast<Index>(v) : parent[row.front()];
    if (root && !row.empty()) roots.push_back(static_cast<Index>(v));
  });
  auto trees = static_cast<std::uint32_t>(roots.size());
  const auto root_of = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  const auto join = [&](Index a, Index b) {
    if (parent[a] == parent[b]) return;
    const Index one = root_of(a), two = root_of(b);
    if (one == two) return;
    parent[std::max(one, two)] = std::min(one, two);
    --trees;
  };
  for (std::size_t i = 0; i < roots.size() && trees > 1; ++i) {
    if (i % kBlockSize == 0 && run.stopped()) break;
    for (const Index w : topology.vertex_neighbours[roots[i]]) join(roots[i], w);
  }
  if (trees < 2) return trees;
  for_each(vertices, run.on_one_thread(), [&](std::size_t v) { parent[v] = root_of(static_cast<Index>(v)); });
  for (std::size_t t = 0; t < triangles.size() && trees > 1; ++t) {
    if (t % kBlockSize == 0 && run.stopped()) break;
    const auto& [a, b, c] = triangles[t];
    join(a, b);
    join(b, c);
  }
  return trees;
}

}  // namespace

Result<Topology> build_topology(std::size_t vertices, std::span<const Triangle> triangles,
                                const RunControl& run) {
  Topology topology;
  topology.face_neighbours.resize(triangles.size());
  topology.vertex_flags.resize(vertices);
  if (!faces_at_vertices(vertices, triangles, run, topology.vertex_faces) ||
      !link_stars(triangles, run, topology) ||
      (topology.opposed_edges > 0 && !mark_opposed(triangles, run, topology))) {
    return run.stop_error();
  }
  topology.components = count_components(triangles, topology, run);
  if (run.stopped()) return run.stop_error();
  return topology;
}

double mean_edge_length(std::span<const Vec3f> positions, const Topology& topology, const RunControl& run) {
  if (topology.edges == 0) return 0;
  const double sum = parallel_sum(positions.size(), run, [&](std::size_t begin, std::size_t end) {
    double lengths = 0;
    constexpr std::size_t kMost = 256;
    std::array<double, kMost> squares;  // for roots in pairs, which take no longer than one
    std::size_t count = 0;
    const auto add_roots = [&] {
      for (std::size_t i = 0; i < count; ++i) squares[i] = std::sqrt(squares[i]);
      for (std::size_t i = 0; i < count; ++i) lengths += squares[i];
      count = 0;
    };
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3d here = to_double(positions[v]);
      for (const Index w : topology.vertex_neighbours[v]) {
        const Vec3d way = to_double(positions[w]) - here;
        squares[count] = dot(way, way);
        count += w > v;  // each edge counts once; which of the two comes first no processor guesses
        if (count == kMost) add_roots();
      }
    }
    add_roots();
    return lengths;
  });
  return sum / topology.edges;
}

}  // namespace burnish
