// What method `auto` sees of a noisy surface: the face normals as they are and as a dozen filters of
// different strength would have them. Where all agree there is nothing to decide; how they differ tells
// noise, edges and folds apart. Only their differences count, so that what is learned from them does not
// depend on how the mesh is turned, moved, scaled or numbered.
#pragma once

#include <array>
#include <span>

#include "core/smooth/normal_filter.h"

namespace burnish {

class NormalFields {
 public:
  /// Field 0 is the normal itself.
  static constexpr std::size_t kFields = 13;
  static constexpr std::size_t kPairs = kFields * (kFields - 1) / 2;
  static constexpr std::size_t kOffsets = 12, kGlobals = 4, kRegionals = 4;
  /// |n_a - n_b| of every two fields; how far the face lies from the means of its neighbours' centroids along
  /// five of the fields, in mean edge lengths, and its size; means of some differences over the whole mesh,
  /// and of some over the region around the face.
  static constexpr std::size_t kInputs = kPairs + kOffsets + kGlobals + kRegionals;
  using Inputs = std::array<float, kInputs>;
  using Weights = std::array<float, kFields>;

  NormalFields(const Surface& surface, const RunControl& run);

  /// Everything from positions, but for the means over the whole mesh, which are those of the first call:
  /// later ones see a smoother mesh, and would not know any more how noisy it was. False when stopped.
  bool measure(std::span<const SimdVec3> positions);

  std::size_t size() const { return faces_.size(); }
  SimdVec3 field(std::size_t number, std::size_t face) const { return fields_[face][number]; }
  /// Thread-safe.
  void describe(std::size_t face, Inputs& inputs) const;
  /// The unit normal along the weighted sum of the fields.
  SimdVec3 blend(std::size_t face, const Weights& weights) const;
  Faces& faces() { return faces_; }
  const Faces& faces() const { return faces_; }

 private:
  using Field = Buffer<SimdVec3>;
  enum class Keep : std::uint8_t;

  template <class Weight>
  bool average(const Field& from, Field& to, Weight&& weight);
  bool narrow(std::span<const SimdVec3> start, float threshold, std::initializer_list<int> steps);
  bool most_even_patch(const Field& from, Field& to);
  bool keep(const Field& field);
  bool mean_centroids();
  void measure_whole();
  bool measure_regions();

  std::span<const Index> neighbours(std::size_t face) const {
    return std::span(items_).subspan(offsets_[face], offsets_[face + 1] - offsets_[face]);
  }

  const RunControl& run_;
  Faces faces_;
  float mean_edge_;
  std::vector<Index> offsets_, items_;  // faces that share a vertex with each face
  Field now_, next_, patch_;
  Buffer<float> evenness_;
  Buffer<SimdVec3> near_centroids_, far_centroids_;  // means over one and three rings
  Buffer<std::array<SimdVec3, kFields>> fields_;
  std::size_t kept_ = 0;
  std::array<float, kGlobals> whole_{};
  bool whole_measured_ = false;
  Buffer<SimdVec3::Lanes> regions_, next_regions_;
};

}  // namespace burnish
