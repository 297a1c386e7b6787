#include "core/io/normal_rows.h"

namespace burnish {

Result<> NormalRows::recompute(const MovedPositions& moved, std::span<const Triangle> triangles,
                               std::span<const Triangle> corners, const RunControl& run) {
  std::vector<Triangle> corner_rows(triangles.size());
  const bool done = for_each(triangles.size(), run, [&](std::size_t t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Index element = corners[t][c];
      corner_rows[t][c] = element == kNone ? kNone : row_of_element[element];
    }
  });
  if (!done) return run.stop_error();
  auto fresh = corner_normals(moved, triangles, corner_rows, rows.size(), run);
  if (!fresh) return fresh.error();
  changed = std::move(fresh->touched);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (fresh->normals[row] == Vec3f{}) changed[row] = 0;
    if (changed[row] != 0) rows[row] = fresh->normals[row];
  }
  return {};
}

}  // namespace burnish
