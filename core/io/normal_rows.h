// Private to the codecs whose normals stand beside vertices: which of them are one normal, and what it is
// after smoothing.
#pragma once

#include <algorithm>
#include <array>
#include <bit>

#include "core/mesh/surface.h"
#include "core/run/parallel.h"

namespace burnish {

/// Elements are places where a file keeps a normal, each beside a vertex of it. Those that share position and
/// normal share a row, so a texture seam in a smooth region stays smooth.
struct NormalRows {
  std::vector<Index> row_of_element;
  std::vector<Vec3f> rows;
  std::vector<std::uint8_t> changed = {};  ///< per row; see recompute()

  /// Recomputes the rows that a triangle with a moved vertex uses. `corners` has the element of each corner
  /// of `triangles`, or kNone. Errors: Cancelled, DeadlineExceeded.
  Result<> recompute(const MovedPositions& moved, std::span<const Triangle> triangles,
                     std::span<const Triangle> corners, const RunControl& run);
};

/// Elements in the order of the surface's vertices that they stand beside.
template <class VertexOf>
Result<IndexRows> elements_by_vertex(std::size_t elements, const MovedPositions& moved, const RunControl& run,
                                     VertexOf vertex_of) {
  IndexRows rows;
  rows.offsets.assign(moved.before.size() + 1, 0);
  rows.items.resize(elements);
  const RunControl one = run.on_one_thread();
  if (!for_each(elements, one, [&](std::size_t e) { ++rows.offsets[moved.weld[vertex_of(e)] + 1]; })) {
    return run.stop_error();
  }
  for (std::size_t v = 0; v < moved.before.size(); ++v) rows.offsets[v + 1] += rows.offsets[v];
  std::vector<Index> next(rows.offsets.begin(), rows.offsets.end() - 1);
  const bool done = for_each(elements, one, [&](std::size_t e) {
    rows.items[next[moved.weld[vertex_of(e)]]++] = static_cast<Index>(e);
  });
  if (!done) return run.stop_error();
  return rows;
}

/// The rows as they are in the file: element e stands beside file vertex vertex_of(e) and holds normal_of(e).
template <class VertexOf, class NormalOf>
Result<NormalRows> group_normals(std::size_t elements, const MovedPositions& moved, const RunControl& run,
                                 VertexOf vertex_of, NormalOf normal_of) {
  using Bits = std::array<std::uint32_t, 3>;
  const auto by_vertex = elements_by_vertex(elements, moved, run, vertex_of);
  if (!by_vertex) return by_vertex.error();
  NormalRows normals{std::vector<Index>(elements), {}};
  std::vector<std::pair<Bits, Index>> here;
  const bool done = for_each(by_vertex->rows(), run.on_one_thread(), [&](std::size_t v) {
    here.clear();
    for (const Index e : (*by_vertex)[v]) here.emplace_back(std::bit_cast<Bits>(Vec3f(normal_of(e))), e);
    std::sort(here.begin(), here.end());
    for (std::size_t i = 0; i < here.size(); ++i) {
      if (i == 0 || here[i].first != here[i - 1].first) {
        normals.rows.push_back(std::bit_cast<Vec3f>(here[i].first));
      }
      normals.row_of_element[here[i].second] = static_cast<Index>(normals.rows.size() - 1);
    }
  });
  if (!done) return run.stop_error();
  return normals;
}

}  // namespace burnish
