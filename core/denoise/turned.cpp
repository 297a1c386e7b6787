#include "core/denoise/turned.h"

#include <algorithm>

namespace burnish {
namespace {

/// Cosines of 60, 20 and 95 degrees.
constexpr float kOff = 0.5F, kTurned = 0.93969F, kSharp = -0.08716F;

/// Until no triangle is too far, half the way of its vertices, and half of that, and all of it. That comes to
/// an end: no triangle is too far whose vertices are all back, and each further round brings at least one
/// back.
template <class Before, class TooFar>
bool take_back(const Faces& faces, std::span<SimdVec3> now, Before&& before, TooFar&& too_far) {
  constexpr int kHalvings = 6;
  const auto& vertex_faces = faces.surface().topology.vertex_faces;
  Buffer<std::uint8_t> far(faces.size());
  const auto is_far = [&](Index f) { return far[f] != 0; };
  bool going = true;
  for (int round = 0; going; ++round) {
    going = for_each(faces.size(), faces.run(), [&](std::size_t f) { far[f] = too_far(f) ? 1 : 0; });
    if (going && std::ranges::find(far, 1) == far.end()) break;
    going = going && for_each(now.size(), faces.run(), [&](std::size_t v) {
              if (std::ranges::none_of(vertex_faces[v], is_far)) return;
              now[v] = round < kHalvings ? before(v) + (now[v] - before(v)) * 0.5F : before(v);
            });
  }
  return going;
}

}  // namespace

bool take_back_turned(const Faces& faces, std::span<const SimdVec3> predicted,
                      std::span<const SimdVec3> before, std::span<SimdVec3> now) {
  const auto new_normal = [&](std::size_t f) { return faces.measured(now, f).normal; };
  const auto old_normal = [&](std::size_t f) { return faces.measured(before, f).normal; };
  const auto has_sharper_edge = [&](std::size_t f, SimdVec3 was, SimdVec3 is) {
    return std::ranges::any_of(faces.surface().topology.face_neighbours[f], [&](Index g) {
      if (g == kNone) return false;
      const float cosine = dot(is, new_normal(g));
      return cosine < kSharp && cosine < dot(was, old_normal(g));
    });
  };
  return take_back(
      faces, now, [&](std::size_t v) { return before[v]; },
      [&](std::size_t f) {
        const SimdVec3 was = old_normal(f), is = new_normal(f);
        const float agrees = dot(is, predicted[f]);
        if (agrees < kOff && agrees < dot(was, predicted[f])) return true;
        return dot(was, is) < kTurned && has_sharper_edge(f, was, is);
      });
}

bool take_back_flipped(const Faces& faces, std::span<const SimdVec3> predicted, std::span<SimdVec3> now) {
  const Mesh& scan = faces.surface().mesh;
  const auto home = [&](Index v) { return SimdVec3(scan.positions[v]); };
  const auto against = [&](std::size_t f, SimdVec3 a, SimdVec3 b, SimdVec3 c) {
    const float side = faces.side(f);
    return dot(cross(b - a, c - a) * side, predicted[f]) < 0;
  };
  return take_back(
      faces, now, [&](std::size_t v) { return SimdVec3(scan.positions[v]); },
      [&](std::size_t f) {
        const auto& [a, b, c] = scan.triangles[f];
        return against(f, now[a], now[b], now[c]) && !against(f, home(a), home(b), home(c));
      });
}

}  // namespace burnish
