#include "core/mesh/surface.h"
#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Rows of corners per normal, so that each normal is summed in the order of the file whatever the threads.
IndexRows corners_by_row(std::span<const Triangle> corner_rows, std::size_t rows) {
  IndexRows by_row;
  by_row.offsets.assign(rows + 1, 0);
  for (const Triangle& t : corner_rows) {
    for (const Index row : t) {
      if (row != kNone) ++by_row.offsets[row + 1];
    }
  }
  for (std::size_t row = 0; row < rows; ++row) by_row.offsets[row + 1] += by_row.offsets[row];
  by_row.items.resize(by_row.offsets[rows]);
  std::vector<Index> next(by_row.offsets.begin(), by_row.offsets.end() - 1);
  for (std::size_t t = 0; t < corner_rows.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (corner_rows[t][c] != kNone) by_row.items[next[corner_rows[t][c]]++] = static_cast<Index>(3 * t + c);
    }
  }
  return by_row;
}

/// Unit normal of the triangle times the angle at the corner; zero for a triangle without area.
Vec3d weighted_normal(const Vec3d& corner, const Vec3d& next, const Vec3d& last) {
  const Vec3d a = next - corner, b = last - corner;
  const Vec3d normal = cross(a, b);
  const double size = length(normal);
  if (size == 0) return {};
  return normal * (portable_angle(size, dot(a, b)) / size);
}

}  // namespace

Result<CornerNormals> corner_normals(const MovedPositions& moved, std::span<const Triangle> triangles,
                                     std::span<const Triangle> corner_rows, std::size_t rows,
                                     const RunControl& run) {
  CornerNormals result{std::vector<Vec3f>(rows), std::vector<std::uint8_t>(rows, 0)};
  const IndexRows by_row = corners_by_row(corner_rows, rows);
  const auto position = [&](Index file_vertex) { return to_double(moved.after[moved.weld[file_vertex]]); };
  const bool done = parallel_for(rows, run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      Vec3d sum;
      for (const Index corner : by_row[row]) {
        const Triangle& t = triangles[corner / 3];
        const Index a = t[corner % 3], b = t[(corner + 1) % 3], c = t[(corner + 2) % 3];
        sum += weighted_normal(position(a), position(b), position(c));
        if (moved.moved(a) || moved.moved(b) || moved.moved(c)) result.touched[row] = 1;
      }
      const double size = length(sum);
      if (size > 0) result.normals[row] = to_float(sum * (1 / size));
    }
  });
  if (!done) return run.stop_error();
  return result;
}

}  // namespace burnish
