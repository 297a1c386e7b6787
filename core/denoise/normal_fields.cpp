#include "core/denoise/normal_fields.h"

#include <algorithm>
#include <cmath>

namespace burnish {
namespace {

/// The fields that offsets of centroids are measured along.
constexpr std::array<std::size_t, 5> kAlong = {0, 2, 5, 8, 12};

float difference(SimdVec3 a, SimdVec3 b) { return length(a - b); }

/// The dot product of one with each of four, in the order of dot().
SimdVec3::Lanes dots(SimdVec3 one, const std::array<SimdVec3, 4>& four) {
  using Lanes = SimdVec3::Lanes;
  const Lanes a = four[0].lanes(), b = four[1].lanes(), c = four[2].lanes(), d = four[3].lanes();
  const Lanes ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Lanes x = __builtin_shufflevector(ab, cd, 0, 1, 4, 5),
              y = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  const Lanes z = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 3, 7),
                                          __builtin_shufflevector(c, d, 2, 6, 3, 7), 0, 1, 4, 5);
  return x * one.x() + y * one.y() + z * one.z();
}

using Lanes = NormalFields::Lanes;

/// A vector per lane.
struct Vectors {
  Lanes x, y, z;
  void set(std::size_t lane, SimdVec3 v) { x[lane] = v.x(), y[lane] = v.y(), z[lane] = v.z(); }
};

// In the order of SimdVec3's.
Lanes dots(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// |a - b|.
Lanes lengths(const Vectors& a, const Vectors& b) {
  const Vectors way{a.x - b.x, a.y - b.y, a.z - b.z};
  const Lanes squares = dots(way, way);
  Lanes roots;
  for (std::size_t lane = 0; lane < NormalFields::kTogether; ++lane) roots[lane] = std::sqrt(squares[lane]);
  return roots;
}

Lanes clamped(Lanes values) {
  constexpr float kMost = 4;
  const Lanes above = values < -kMost ? Lanes{} - kMost : values;
  return above > kMost ? Lanes{} + kMost : above;
}

}  // namespace

bool NormalFields::start(const FacePatch& patch, std::span<const SimdVec3> positions) {
  patch_ = &patch;
  for_each_buffer([&](auto& buffer) {
    buffer.clear();  // nothing to copy when it grows
    buffer.resize(patch.size());
  });
  return for_each(patch.size(), run(), [&](std::size_t f) {
    const auto face = patch.mesh().measured(positions, patch.face(f));
    fields_[f][0] = face.normal;
    twice_areas_[f] = face.twice_area;
    centroids_[f] = face.centroid;
  });
}

void NormalFields::release() {
  for_each_buffer([](auto& buffer) { std::remove_reference_t<decltype(buffer)>().swap(buffer); });
}

bool NormalFields::copy(std::size_t field, Field& to, std::uint32_t rings) {
  return for_each(patch_->within(rings), run(), [&](std::size_t f) { to[f] = fields_[f][field]; });
}

/// `from` is good on so many rings.
bool NormalFields::keep(std::size_t field, const Field& from, std::uint32_t rings) {
  const std::size_t count = patch_->within(std::min(rings, kRegionRings + kPatchRings));
  return for_each(count, run(), [&](std::size_t f) { fields_[f][field] = from[f]; });
}

/// to(i) = unit(sum over neighbours j and i itself of A(j) weight(n(i) . n(j)) n(j)). Neighbours are weighed
/// by fours and added one by one.
template <class Weight>
bool NormalFields::average(const Field& from, Field& to, std::uint32_t rings, Weight&& weight) {
  return for_each(patch_->within(rings), run(), [&](std::size_t f) {
    const SimdVec3 own = from[f];
    SimdVec3 sum = own * (twice_areas_[f] * weight(1.0F));
    std::span<const Index> near = neighbours(f);
    for (; near.size() >= 4; near = near.subspan(4)) {
      const Index a = near[0], b = near[1], c = near[2], d = near[3];
      const SimdVec3::Lanes areas{twice_areas_[a], twice_areas_[b], twice_areas_[c], twice_areas_[d]};
      const SimdVec3::Lanes weights = areas * weight(dots(own, {from[a], from[b], from[c], from[d]}));
      sum += from[a] * weights[0];
      sum += from[b] * weights[1];
      sum += from[c] * weights[2];
      sum += from[d] * weights[3];
    }
    for (const Index n : near) sum += from[n] * (twice_areas_[n] * weight(dot(own, from[n])));
    to[f] = unit_or(sum, twice_areas_[f], own);
  });
}

/// Steps from the normals as they are, some of which are kept as fields.
template <class Weight>
bool NormalFields::filter(std::initializer_list<Kept> kept, Weight&& weight) {
  std::uint32_t rings = kRegionRings + std::prev(kept.end())->steps;
  if (!copy(0, now_, rings)) return false;
  std::uint32_t done = 0;
  for (const Kept& each : kept) {
    for (; done < each.steps; ++done) {
      if (!average(now_, next_, --rings, weight)) return false;
      now_.swap(next_);
    }
    if (!keep(each.field, now_, rings)) return false;
  }
  return true;
}

bool NormalFields::widen() {
  return filter({{1, 1}, {3, 2}, {6, 3}}, [](auto cosine) { return decltype(cosine){} + 1; });
}

/// Neighbours count by how much the cosine of the angle exceeds the threshold, squared (Sun et al. 2007).
bool NormalFields::narrow(float threshold, std::initializer_list<Kept> kept) {
  return filter(kept, [&](auto cosine) {
    const auto past = cosine - threshold;
    const auto above = past < 0 ? decltype(cosine){} : past;
    return above * above;
  });
}

/// to(i) = the mean normal of the patch (a face and its neighbours) around i or a neighbour of i whose
/// normals agree best: beside an edge that is a patch which does not cross it (Kuwahara's filter for images,
/// the guidance of Zhang et al. 2015).
bool NormalFields::most_even_patch(const Field& from, Field& to, std::uint32_t rings) {
  const bool measured = for_each(patch_->within(rings + 1), run(), [&](std::size_t f) {
    SimdVec3 sum = from[f] * twice_areas_[f];
    float areas = twice_areas_[f];
    for (const Index n : neighbours(f)) {
      sum += from[n] * twice_areas_[n];
      areas += twice_areas_[n];
    }
    const float size = length(sum);
    means_[f] = areas > 0 && size > 1e-6F * areas ? sum * (1 / size) : from[f];
    evenness_[f] = areas > 0 ? size / areas : 0;
  });
  return measured && for_each(patch_->within(rings), run(), [&](std::size_t f) {
           std::size_t best = f;
           for (const Index n : neighbours(f)) {
             if (evenness_[n] > evenness_[best]) best = n;
           }
           to[f] = means_[best];
         });
}

/// Fields 10 and 11: once, and three times; 12: once, after a mild filter.
bool NormalFields::choose_patches() {
  std::uint32_t rings = kRegionRings + 3 * kPatchRings;
  if (!copy(0, now_, rings)) return false;
  for (int step = 1; step <= 3; ++step) {
    rings -= kPatchRings;
    if (!most_even_patch(now_, next_, rings)) return false;
    now_.swap(next_);
    if (step != 2 && !keep(step == 1 ? 10 : 11, now_, rings)) return false;
  }
  return copy(4, now_, kRegionRings + kPatchRings) && most_even_patch(now_, next_, kRegionRings) &&
         keep(12, next_, kRegionRings);
}

bool NormalFields::mean_centroids() {
  const auto mean = [&](const Field& from, Field& to, std::uint32_t rings) {
    return for_each(patch_->within(rings), run(), [&](std::size_t f) {
      SimdVec3 sum = from[f] * twice_areas_[f];
      float areas = twice_areas_[f];
      for (const Index n : neighbours(f)) {
        sum += from[n] * twice_areas_[n];
        areas += twice_areas_[n];
      }
      to[f] = areas > 0 ? sum * (1 / areas) : from[f];
    });
  };
  return mean(centroids_, near_centroids_, 2) && mean(near_centroids_, next_, 1) &&
         mean(next_, far_centroids_, 0);
}

bool NormalFields::measure_differences(const FacePatch& patch, std::span<const SimdVec3> positions) {
  return start(patch, positions) && widen() && narrow(0.6F, {{3, 7}, {8, 8}}) && measure_local_areas();
}

bool NormalFields::measure(const FacePatch& patch, std::span<const SimdVec3> positions) {
  return measure_differences(patch, positions) && narrow(0.2F, {{2, 4}, {6, 5}, {14, 6}}) &&
         narrow(0.85F, {{8, 9}}) && choose_patches() && mean_centroids() && measure_regions();
}

NormalFields::Differences NormalFields::differences(std::size_t face) const {
  const auto& n = fields_[face];
  return {difference(n[0], n[1]), difference(n[0], n[3]), difference(n[1], n[3]), difference(n[0], n[8])};
}

/// Averaged over a ring again and again.
template <class Value>
bool NormalFields::average_over_rings(std::uint32_t rings, Buffer<Value>& values, Buffer<Value>& next) {
  for (std::uint32_t ring = rings; ring-- > 0;) {
    const bool done = for_each(patch_->within(ring), run(), [&](std::size_t f) {
      Value sum = values[f];
      for (const Index n : neighbours(f)) sum += values[n];
      next[f] = sum / (1 + static_cast<float>(neighbours(f).size()));
    });
    if (!done) return false;
    values.swap(next);
  }
  return true;
}

bool NormalFields::measure_local_areas() {
  constexpr std::size_t kSmoothed = 2;
  return for_each(patch_->within(kAreaRings), run(),
                  [&](std::size_t f) {
                    const float seen = dot(fields_[f][0], fields_[f][kSmoothed]);
                    local_areas_[f] = twice_areas_[f] * std::max(seen, 0.0F);
                  }) &&
         average_over_rings(kAreaRings, local_areas_, evenness_);
}

/// What the surface is like around a face.
bool NormalFields::measure_regions() {
  return for_each(patch_->within(kRegionRings), run(),
                  [&](std::size_t f) {
                    const auto& n = fields_[f];
                    regions_[f] = SimdVec3::Lanes{difference(n[0], n[3]), difference(n[3], n[8]),
                                                  difference(n[6], n[11]), difference(n[1], n[12])};
                  }) &&
         average_over_rings(kRegionRings, regions_, next_regions_);
}

float NormalFields::Whole::fineness(float local) const {
  constexpr float kLeast = 0.25F, kMost = 1.5F;
  if (!(local_area > 0)) return 1;
  if (!(local * kMost * kMost > local_area)) return kMost;
  return std::max(std::sqrt(local_area / local), kLeast);
}

NormalFields::Differences NormalFields::Whole::usual(float fineness) const {
  Differences means;
  for (std::size_t i = 0; i < kGlobals; ++i) means[i] = std::max(constant[i] + slope[i] * fineness, 0.0F);
  return means;
}

void NormalFields::describe(std::size_t first, std::size_t count, const Whole& whole, Inputs& inputs) const {
  const float per_edge = mean_edge_ > 0 ? 1 / mean_edge_ : 0;
  std::array<Vectors, kFields> n;
  Vectors near, far;
  std::array<Lanes, 1 + kGlobals + kRegionals> rest;
  for (std::size_t lane = 0; lane < kTogether; ++lane) {
    const std::size_t face = first + std::min(lane, count - 1);
    for (std::size_t k = 0; k < kFields; ++k) n[k].set(lane, fields_[face][k]);
    near.set(lane, (near_centroids_[face] - centroids_[face]) * per_edge);
    far.set(lane, (far_centroids_[face] - centroids_[face]) * per_edge);
    rest[0][lane] = std::min(std::sqrt(twice_areas_[face]) * per_edge, 4.0F);
    const Differences usual = whole.usual(whole.fineness(local_areas_[face]));
    for (std::size_t i = 0; i < kGlobals; ++i) rest[1 + i][lane] = usual[i];
    for (std::size_t i = 0; i < kRegionals; ++i) rest[1 + kGlobals + i][lane] = regions_[face][i];
  }
  std::size_t at = 0;
  for (std::size_t a = 0; a < kFields; ++a) {
    for (std::size_t b = a + 1; b < kFields; ++b) inputs[at++] = lengths(n[a], n[b]);
  }
  for (const std::size_t along : kAlong) {
    inputs[at++] = clamped(dots(near, n[along]));
    inputs[at++] = clamped(dots(far, n[along]));
  }
  inputs[at++] = rest[0];
  inputs[at++] = clamped(lengths(far, near));
  std::copy(rest.begin() + 1, rest.end(), inputs.begin() + static_cast<std::ptrdiff_t>(at));
}

SimdVec3 NormalFields::blend(std::size_t face, const Weights& weights) const {
  const auto& fields = fields_[face];
  SimdVec3 sum;
  for (std::size_t k = 0; k < kFields; ++k) sum += fields[k] * weights[k];
  return unit_or(sum, 1, fields[0]);
}

}  // namespace burnish
