#include "core/io/glb_overlap.h"

#include <algorithm>

namespace burnish {
namespace {

enum class Use : std::uint8_t { Positions, Normals, Other };

struct Stretch {
  Index buffer;
  std::uint64_t begin, end, stride, row;
  Use use;
  Index vertices;  // of Positions
};

Stretch stretch_of(const GlbAccessor& accessor, Use use, Index vertices = kNone) {
  return {accessor.buffer, accessor.begin, accessor.end(), accessor.stride, accessor.row_bytes(), use,
          vertices};
}

std::vector<Stretch> all_stretches(const GlbDocument& document, std::span<const GlbAccessor> read_only) {
  std::vector<Stretch> all;
  for (const GlbVertices& vertices : document.vertices()) {
    const auto index = static_cast<Index>(&vertices - document.vertices().data());
    if (vertices.draco == nullptr) {
      all.push_back(stretch_of(vertices.positions, Use::Positions, index));
    } else {
      const GlbView& view = vertices.place;
      all.push_back(
          {view.buffer, view.begin, view.begin + view.length, view.length, view.length, Use::Other, kNone});
    }
  }
  for (const GlbNormals& normals : document.normals()) {
    if (normals.draco_attribute < 0) all.push_back(stretch_of(normals.accessor, Use::Normals));
  }
  for (const GlbAccessor& accessor : read_only) all.push_back(stretch_of(accessor, Use::Other));
  std::ranges::sort(all, [](const Stretch& a, const Stretch& b) {
    return std::pair(a.buffer, a.begin) < std::pair(b.buffer, b.begin);
  });
  return all;
}

/// Whether rows of one stretch meet rows of another otherwise than as the same rows.
bool collide(std::span<const Stretch> group) {
  if (std::ranges::all_of(group, [](const Stretch& s) { return s.use == Use::Other; })) return false;
  struct Phase {
    std::uint64_t at, row;
    Use use;
    auto operator<=>(const Phase&) const = default;
  };
  const std::uint64_t stride = group.front().stride;
  std::vector<Phase> phases;
  for (const Stretch& s : group) {
    if (s.stride != stride) return true;
    phases.push_back({s.begin % stride, s.row, s.use});
  }
  std::ranges::sort(phases);
  phases.erase(std::unique(phases.begin(), phases.end()), phases.end());
  for (std::size_t i = 0; i < phases.size() && phases.size() > 1; ++i) {
    const bool last = i + 1 == phases.size();
    const std::uint64_t next = last ? phases.front().at + stride : phases[i + 1].at;
    if (phases[i].at + phases[i].row > next) return true;
  }
  return false;
}

}  // namespace

Result<> check_overlaps(const GlbDocument& document, std::span<const GlbAccessor> read_only,
                        const std::function<void(Index, Index)>& same) {
  const std::vector<Stretch> all = all_stretches(document, read_only);
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    std::uint64_t reach = all[begin].end;
    for (end = begin + 1; end < all.size() && all[end].buffer == all[begin].buffer && all[end].begin < reach;
         ++end) {
      reach = std::max(reach, all[end].end);
    }
    const std::span<const Stretch> group(all.data() + begin, end - begin);
    if (collide(group)) {
      return Error{Cause::MalformedMesh, "positions share bytes " + std::to_string(all[begin].begin) +
                                             " to " + std::to_string(reach) + " of buffers[" +
                                             std::to_string(all[begin].buffer) +
                                             "] with something else that would change with them"};
    }
    const Stretch* first = nullptr;
    for (const Stretch& s : group) {
      if (s.use != Use::Positions) continue;
      if (first == nullptr) first = &s;
      same(first->vertices, s.vertices);
    }
  }
  return {};
}

}  // namespace burnish
