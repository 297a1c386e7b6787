#include "core/denoise/normal_fields.h"

#include <algorithm>

namespace burnish {
namespace {

/// The fields that offsets of centroids are measured along.
constexpr std::array<std::size_t, 5> kAlong = {0, 2, 5, 8, 12};

SimdVec3 unit(SimdVec3 sum, SimdVec3 otherwise) {
  const float squared = dot(sum, sum);
  return squared > 1e-12F ? sum * (1 / std::sqrt(squared)) : otherwise;
}

float difference(SimdVec3 a, SimdVec3 b) { return length(a - b); }

}  // namespace

NormalFields::NormalFields(const Surface& surface, const RunControl& run)
    : run_(run),
      faces_(surface, FaceNeighbourhood::Vertices, run),
      mean_edge_(static_cast<float>(surface.mean_edge)),
      offsets_(faces_.size() + 1),
      now_(faces_.size()),
      next_(faces_.size()),
      patch_(faces_.size()),
      evenness_(faces_.size()),
      near_centroids_(faces_.size()),
      far_centroids_(faces_.size()),
      fields_(faces_.size()),
      regions_(faces_.size()),
      next_regions_(faces_.size()) {
  const auto count = [&](std::size_t f) {
    Index neighbours = 0;
    faces_.for_each_neighbour(f, [&](Index) { ++neighbours; });
    offsets_[f + 1] = neighbours;
  };
  if (!for_each(faces_.size(), run, count)) return;
  for (std::size_t f = 0; f < faces_.size(); ++f) offsets_[f + 1] += offsets_[f];
  items_.resize(offsets_.back());
  for_each(faces_.size(), run, [&](std::size_t f) {
    Index at = offsets_[f];
    faces_.for_each_neighbour(f, [&](Index n) { items_[at++] = n; });
  });
}

bool NormalFields::keep(const Field& field) {
  const std::size_t number = kept_++;
  return for_each(size(), run_, [&](std::size_t f) { fields_[f][number] = field[f]; });
}

/// to(i) = unit(sum over neighbours j and i itself of A(j) weight(n(i) . n(j)) n(j)).
template <class Weight>
bool NormalFields::average(const Field& from, Field& to, Weight&& weight) {
  return for_each(size(), run_, [&](std::size_t f) {
    const SimdVec3 own = from[f];
    SimdVec3 sum = own * (faces_.twice_area(f) * weight(1.0F));
    for (const Index n : neighbours(f)) sum += from[n] * (faces_.twice_area(n) * weight(dot(own, from[n])));
    to[f] = unit_or(sum, faces_.twice_area(f), own);
  });
}

/// Neighbours count by how much the cosine of the angle exceeds the threshold, squared (Sun et al. 2007).
/// Keeps the field after so many steps.
bool NormalFields::narrow(std::span<const SimdVec3> start, float threshold,
                          std::initializer_list<int> steps) {
  if (!for_each(size(), run_, [&](std::size_t f) { now_[f] = start[f]; })) return false;
  int done = 0;
  for (const int step : steps) {
    for (; done < step; ++done) {
      const auto weight = [&](float cosine) {
        const float above = std::max(cosine - threshold, 0.0F);
        return above * above;
      };
      if (!average(now_, next_, weight)) return false;
      now_.swap(next_);
    }
    if (!keep(now_)) return false;
  }
  return true;
}

/// to(i) = the mean normal of the patch (a face and its neighbours) around i or a neighbour of i whose
/// normals agree best: beside an edge that is a patch which does not cross it (Kuwahara's filter for images,
/// the guidance of Zhang et al. 2015).
bool NormalFields::most_even_patch(const Field& from, Field& to) {
  const bool measured = for_each(size(), run_, [&](std::size_t f) {
    SimdVec3 sum = from[f] * faces_.twice_area(f);
    float areas = faces_.twice_area(f);
    for (const Index n : neighbours(f)) {
      sum += from[n] * faces_.twice_area(n);
      areas += faces_.twice_area(n);
    }
    const float size = length(sum);
    patch_[f] = areas > 0 && size > 1e-6F * areas ? sum * (1 / size) : from[f];
    evenness_[f] = areas > 0 ? size / areas : 0;
  });
  return measured && for_each(size(), run_, [&](std::size_t f) {
           std::size_t best = f;
           for (const Index n : neighbours(f)) {
             if (evenness_[n] > evenness_[best]) best = n;
           }
           to[f] = patch_[best];
         });
}

bool NormalFields::mean_centroids() {
  const auto mean = [&](auto&& from, Buffer<SimdVec3>& to) {
    return for_each(size(), run_, [&](std::size_t f) {
      SimdVec3 sum = from(f) * faces_.twice_area(f);
      float areas = faces_.twice_area(f);
      for (const Index n : neighbours(f)) {
        sum += from(n) * faces_.twice_area(n);
        areas += faces_.twice_area(n);
      }
      to[f] = areas > 0 ? sum * (1 / areas) : from(f);
    });
  };
  return mean([&](std::size_t f) { return faces_.centroid(f); }, near_centroids_) &&
         mean([&](std::size_t f) { return near_centroids_[f]; }, next_) &&
         mean([&](std::size_t f) { return next_[f]; }, far_centroids_);
}

bool NormalFields::measure(std::span<const SimdVec3> positions) {
  if (!faces_.measure(positions)) return false;
  kept_ = 0;
  const auto raw = faces_.normals();
  const auto even = [](float) { return 1.0F; };
  if (!for_each(size(), run_, [&](std::size_t f) { now_[f] = raw[f]; }) || !keep(now_)) return false;
  for (int step = 1; step <= 6; ++step) {  // fields 1 to 3: after 1, 3 and 6 steps
    if (!average(now_, next_, even)) return false;
    now_.swap(next_);
    if ((step == 1 || step == 3 || step == 6) && !keep(now_)) return false;
  }
  if (!narrow(raw, 0.2F, {2, 6, 14}) ||  // 4 to 6
      !narrow(raw, 0.6F, {3, 8}) ||      // 7 and 8
      !narrow(raw, 0.85F, {8})) {        // 9
    return false;
  }
  if (!for_each(size(), run_, [&](std::size_t f) { now_[f] = raw[f]; })) return false;
  for (int step = 1; step <= 3; ++step) {  // 10 and 11: once, and three times
    if (!most_even_patch(now_, next_)) return false;
    now_.swap(next_);
    if (step != 2 && !keep(now_)) return false;
  }
  const auto mild = [&](std::size_t f) { now_[f] = fields_[f][4]; };
  if (!for_each(size(), run_, mild) || !most_even_patch(now_, next_) || !keep(next_)) return false;  // 12
  if (!mean_centroids()) return false;
  if (!whole_measured_) measure_whole();
  return !run_.stopped() && measure_regions();
}

void NormalFields::measure_whole() {
  const auto mean_difference = [&](std::size_t a, std::size_t b) {
    const double sum = parallel_sum(size(), run_, [&](std::size_t begin, std::size_t end) {
      double differences = 0;
      for (std::size_t f = begin; f < end; ++f)
        differences += static_cast<double>(difference(fields_[f][a], fields_[f][b]));
      return differences;
    });
    return static_cast<float>(sum / static_cast<double>(std::max<std::size_t>(size(), 1)));
  };
  whole_measured_ = true;
  whole_ = {mean_difference(0, 1), mean_difference(0, 3), mean_difference(1, 3), mean_difference(0, 8)};
}

/// Differences averaged over a ring again and again: what the surface is like around a face.
bool NormalFields::measure_regions() {
  constexpr int kRings = 6;
  const bool measured = for_each(size(), run_, [&](std::size_t f) {
    const auto& n = fields_[f];
    regions_[f] = SimdVec3::Lanes{difference(n[0], n[3]), difference(n[3], n[8]), difference(n[6], n[11]),
                                  difference(n[1], n[12])};
  });
  if (!measured) return false;
  for (int ring = 0; ring < kRings; ++ring) {
    const bool done = for_each(size(), run_, [&](std::size_t f) {
      SimdVec3::Lanes sum = regions_[f];
      for (const Index n : neighbours(f)) sum += regions_[n];
      next_regions_[f] = sum / (1 + static_cast<float>(neighbours(f).size()));
    });
    if (!done) return false;
    regions_.swap(next_regions_);
  }
  return true;
}

void NormalFields::describe(std::size_t face, Inputs& inputs) const {
  const auto& fields = fields_[face];
  std::size_t at = 0;
  for (std::size_t a = 0; a < kFields; ++a) {
    for (std::size_t b = a + 1; b < kFields; ++b) inputs[at++] = difference(fields[a], fields[b]);
  }
  const float per_edge = mean_edge_ > 0 ? 1 / mean_edge_ : 0;
  const SimdVec3 near = (near_centroids_[face] - faces_.centroid(face)) * per_edge,
                 far = (far_centroids_[face] - faces_.centroid(face)) * per_edge;
  for (const std::size_t along : kAlong) {
    inputs[at++] = std::clamp(dot(near, fields[along]), -4.0F, 4.0F);
    inputs[at++] = std::clamp(dot(far, fields[along]), -4.0F, 4.0F);
  }
  inputs[at++] = std::min(std::sqrt(faces_.twice_area(face)) * per_edge, 4.0F);
  inputs[at++] = std::min(length(far - near), 4.0F);
  for (const float mean : whole_) inputs[at++] = mean;
  for (std::size_t i = 0; i < kRegionals; ++i) inputs[at++] = regions_[face][i];
}

SimdVec3 NormalFields::blend(std::size_t face, const Weights& weights) const {
  const auto& fields = fields_[face];
  SimdVec3 sum;
  for (std::size_t k = 0; k < kFields; ++k) sum += fields[k] * weights[k];
  return unit(sum, fields[0]);
}

}  // namespace burnish
