#include "core/io/seams.h"

#include <unordered_map>

#include "core/run/parallel.h"

namespace burnish {
namespace {

struct PointHash {
  std::size_t operator()(const SeamPoint& p) const {
    std::uint64_t h = (std::uint64_t{p.vertex} << 32 | p.normal) * 0x9E3779B97F4A7C15u;
    h = ((h ^ (h >> 29)) + p.texture) * 0xBF58476D1CE4E5B9u;
    return static_cast<std::size_t>(h ^ (h >> 32));
  }
};

}  // namespace

Result<SeamPoints> split_at_seams(std::size_t vertices, std::span<const Triangle> triangles,
                                  const SharedAttributes& attributes, const RunControl& run) {
  SeamPoints result;
  result.points.resize(vertices);
  for (Index v = 0; v < vertices; ++v) result.points[v].vertex = v;
  result.triangles.resize(triangles.size());
  std::vector<std::uint8_t> used(vertices, 0);
  std::unordered_map<SeamPoint, Index, PointHash> copies;

  const auto row = [](const std::optional<MeshAttribute>& attribute, std::size_t t, std::size_t c) {
    return attribute ? attribute->corners[t][c] : kNone;
  };
  const bool done = for_each(triangles.size(), run.on_one_thread(), [&](std::size_t t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Index v = triangles[t][c];
      const SeamPoint wanted{v, row(attributes.normals, t, c), row(attributes.texture_coordinates, t, c)};
      if (used[v] == 0) {
        used[v] = 1;
        result.points[v] = wanted;
      }
      result.triangles[t][c] = v;
      if (result.points[v] == wanted) continue;
      const auto [copy, is_new] = copies.try_emplace(wanted, static_cast<Index>(result.points.size()));
      if (is_new) result.points.push_back(wanted);
      result.triangles[t][c] = copy->second;
    }
  });
  if (!done) return run.stop_error();
  return result;
}

}  // namespace burnish
