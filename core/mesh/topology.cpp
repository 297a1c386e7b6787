#include "core/mesh/topology.h"

#include <algorithm>
#include <numeric>

#include "core/run/parallel.h"

namespace burnish {
namespace {

/// One triangle's use of the edge between its row's vertex a and b > a.
struct EdgeUse {
  Index b;
  Index face;
  std::uint8_t side;     // which of the triangle's edges: 0 = ab, 1 = bc, 2 = ca
  std::uint8_t forward;  // the triangle runs from a to b
};

/// Turns counts per row (in offsets[row + 1]) into offsets.
void counts_to_offsets(std::vector<Index>& offsets) {
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
}

IndexRows faces_at_vertices(std::size_t vertices, std::span<const Triangle> triangles) {
  IndexRows rows;
  rows.offsets.assign(vertices + 1, 0);
  for (const Triangle& t : triangles) {
    for (const Index v : t) ++rows.offsets[v + 1];
  }
  counts_to_offsets(rows.offsets);
  rows.items.resize(triangles.size() * 3);
  std::vector<Index> next(rows.offsets.begin(), rows.offsets.end() - 1);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    for (const Index v : triangles[f]) rows.items[next[v]++] = static_cast<Index>(f);
  }
  return rows;
}

struct EdgeTable {
  std::vector<Index> offsets;  // by the edge's smaller vertex
  std::vector<EdgeUse> uses;   // sorted by (b, face) within a row
};

/// Sorting within rows keeps this O(n log valence), even for a fan of a million triangles around one vertex.
EdgeTable collect_edges(std::size_t vertices, std::span<const Triangle> triangles, const RunControl& run) {
  EdgeTable table;
  table.offsets.assign(vertices + 1, 0);
  for (const Triangle& t : triangles) {
    for (int e = 0; e < 3; ++e) ++table.offsets[std::min(t[e], t[(e + 1) % 3]) + 1];
  }
  counts_to_offsets(table.offsets);
  table.uses.resize(triangles.size() * 3);
  std::vector<Index> next(table.offsets.begin(), table.offsets.end() - 1);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    for (std::uint8_t e = 0; e < 3; ++e) {
      const Index from = triangles[f][e], to = triangles[f][(e + 1) % 3];
      table.uses[next[std::min(from, to)]++] = {std::max(from, to), static_cast<Index>(f), e, from < to};
    }
  }
  parallel_for(vertices, run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      std::sort(table.uses.begin() + table.offsets[a], table.uses.begin() + table.offsets[a + 1],
                [](const EdgeUse& l, const EdgeUse& r) { return l.b != r.b ? l.b < r.b : l.face < r.face; });
    }
  });
  return table;
}

void flag(Topology& topology, Index a, Index b, VertexFlag bit) {
  topology.vertex_flags[a] |= bit;
  topology.vertex_flags[b] |= bit;
}

void connect(Topology& topology, const EdgeUse& one, const EdgeUse& two) {
  topology.face_neighbours[one.face][one.side] = two.face;
  topology.face_neighbours[two.face][two.side] = one.face;
  if (one.forward != two.forward) return;
  ++topology.opposed_edges;
  if (topology.opposed_neighbours.empty()) {
    topology.opposed_neighbours.assign(topology.face_neighbours.size(), 0);
  }
  topology.opposed_neighbours[one.face] |= static_cast<std::uint8_t>(1U << one.side);
  topology.opposed_neighbours[two.face] |= static_cast<std::uint8_t>(1U << two.side);
}

/// Calls visit(a, uses of one edge) for every edge, by ascending (a, b).
template <class Visit>
bool for_each_edge(const EdgeTable& table, const RunControl& run, Visit&& visit) {
  for (std::size_t a = 0; a + 1 < table.offsets.size(); ++a) {
    if (a % kBlockSize == 0 && run.stopped()) return false;
    for (Index i = table.offsets[a]; i < table.offsets[a + 1];) {
      Index j = i + 1;
      while (j < table.offsets[a + 1] && table.uses[j].b == table.uses[i].b) ++j;
      visit(static_cast<Index>(a), std::span<const EdgeUse>(&table.uses[i], j - i));
      i = j;
    }
  }
  return true;
}

bool link_edges(const EdgeTable& table, const RunControl& run, Topology& topology) {
  IndexRows& rows = topology.vertex_neighbours;
  const bool done = for_each_edge(table, run, [&](Index a, std::span<const EdgeUse> uses) {
    ++topology.edges;
    ++rows.offsets[a + 1];
    ++rows.offsets[uses[0].b + 1];
    if (uses.size() == 1) {
      ++topology.boundary_edges;
      flag(topology, a, uses[0].b, kBoundaryVertex);
    } else if (uses.size() == 2) {
      connect(topology, uses[0], uses[1]);
    } else {
      ++topology.non_manifold_edges;
      flag(topology, a, uses[0].b, kNonManifoldVertex);
    }
  });
  if (!done) return false;
  counts_to_offsets(rows.offsets);
  rows.items.resize(std::size_t{topology.edges} * 2);
  std::vector<Index> next(rows.offsets.begin(), rows.offsets.end() - 1);
  return for_each_edge(table, run, [&](Index a, std::span<const EdgeUse> uses) {
    rows.items[next[a]++] = uses[0].b;
    rows.items[next[uses[0].b]++] = a;
  });
}

/// The side of `triangle` that touches `vertex` and is not `side`.
int other_side(const Triangle& triangle, Index vertex, int side) {
  const int corner = triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
  const int leaving = corner, arriving = (corner + 2) % 3;
  return side == leaving ? arriving : leaving;
}

/// Triangles reached from the first one at `vertex` by walking across shared edges, in both directions.
std::size_t fan_size(Index vertex, std::span<const Triangle> triangles, const Topology& topology) {
  const Index start = topology.vertex_faces[vertex][0];
  const int first = other_side(triangles[start], vertex, -1);
  std::size_t reached = 1;
  for (const int direction : {first, other_side(triangles[start], vertex, first)}) {
    Index face = start;
    int side = direction;
    for (;;) {
      const Index next = topology.face_neighbours[face][side];
      if (next == kNone) break;           // the open end: walk the other way
      if (next == start) return reached;  // all the way round
      const Triangle& neighbours = topology.face_neighbours[next];
      int entry = 0;
      while (neighbours[entry] != face) ++entry;
      side = other_side(triangles[next], vertex, entry);
      face = next;
      ++reached;
    }
  }
  return reached;
}

bool flag_vertices(std::span<const Triangle> triangles, const RunControl& run, Topology& topology) {
  return parallel_for(topology.vertex_flags.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Index vertex = static_cast<Index>(v);
      const auto faces = topology.vertex_faces[v];
      if (faces.empty()) {
        topology.vertex_flags[v] |= kIsolatedVertex;
      } else if (!topology.has(vertex, kNonManifoldVertex) &&
                 fan_size(vertex, triangles, topology) != faces.size()) {
        topology.vertex_flags[v] |= kNonManifoldVertex;
      }
    }
  });
}

std::uint32_t count_components(const Topology& topology, const RunControl& run) {
  std::vector<std::uint8_t> seen(topology.vertex_flags.size(), 0);
  std::vector<Index> stack;
  std::uint32_t components = 0, steps = 0;
  for (Index v = 0; v < seen.size(); ++v) {
    if (seen[v] || topology.has(v, kIsolatedVertex)) continue;
    ++components;
    seen[v] = 1;
    stack.push_back(v);
    while (!stack.empty()) {
      if (++steps % kBlockSize == 0 && run.stopped()) return components;
      const Index at = stack.back();
      stack.pop_back();
      for (const Index next : topology.vertex_neighbours[at]) {
        if (seen[next]) continue;
        seen[next] = 1;
        stack.push_back(next);
      }
    }
  }
  return components;
}

}  // namespace

Result<Topology> build_topology(std::size_t vertices, std::span<const Triangle> triangles,
                                const RunControl& run) {
  Topology topology;
  topology.vertex_faces = faces_at_vertices(vertices, triangles);
  topology.vertex_neighbours.offsets.assign(vertices + 1, 0);
  topology.face_neighbours.assign(triangles.size(), {kNone, kNone, kNone});
  topology.vertex_flags.assign(vertices, 0);
  if (run.stopped()) return run.stop_error();
  const EdgeTable edges = collect_edges(vertices, triangles, run);
  if (run.stopped() || !link_edges(edges, run, topology) || !flag_vertices(triangles, run, topology)) {
    return run.stop_error();
  }
  for (const std::uint8_t flags : topology.vertex_flags) {
    topology.non_manifold_vertices += (flags & kNonManifoldVertex) != 0;
    topology.isolated_vertices += (flags & kIsolatedVertex) != 0;
  }
  topology.components = count_components(topology, run);
  if (run.stopped()) return run.stop_error();
  return topology;
}

double mean_edge_length(std::span<const Vec3f> positions, const Topology& topology, const RunControl& run) {
  if (topology.edges == 0) return 0;
  const double sum = parallel_sum(positions.size(), run, [&](std::size_t begin, std::size_t end) {
    double lengths = 0;
    for (std::size_t v = begin; v < end; ++v) {
      for (const Index w : topology.vertex_neighbours[v]) {
        if (w > v) lengths += length(to_double(positions[w]) - to_double(positions[v]));
      }
    }
    return lengths;
  });
  return sum / topology.edges;
}

}  // namespace burnish
