// What method `auto` sees of a noisy surface: the face normals as they are and as a dozen filters of
// different strength would have them. Where all agree there is nothing to decide; how they differ tells
// noise, edges and folds apart. Only their differences count, so that what is learned from them does not
// depend on how the mesh is turned, moved, scaled or numbered.
#pragma once

#include <array>
#include <span>

#include "core/denoise/face_patch.h"

namespace burnish {

class NormalFields {
 public:
  /// Field 0 is the normal itself.
  static constexpr std::size_t kFields = 13;
  static constexpr std::size_t kPairs = kFields * (kFields - 1) / 2;
  static constexpr std::size_t kOffsets = 12, kGlobals = 4, kRegionals = 4;
  /// |n_a - n_b| of every two fields; how far the face lies from the means of its neighbours' centroids along
  /// five of the fields, in mean edge lengths, and its size; means of some differences over the whole mesh,
  /// of triangles as large as those around the face, and of some over the region around it.
  static constexpr std::size_t kInputs = kPairs + kOffsets + kGlobals + kRegionals;
  /// Faces that are described together, one per lane.
  static constexpr std::size_t kTogether = 8;
  using Lanes = float __attribute__((vector_size(4 * kTogether)));
  using Inputs = std::array<Lanes, kInputs>;
  using Weights = std::array<float, kFields>;

  using Differences = std::array<float, kGlobals>;
  /// Means of differences over the whole mesh, by how fine it is: noise turns small triangles farther than
  /// large ones, so what is usual on the mesh is not what is usual here.
  struct Whole {
    Differences constant{}, slope{};  ///< the mean is constant + slope fineness
    float local_area = 0;             ///< mean of local_area()

    /// sqrt(mean local area / this one), from 1/4 to 3/2.
    float fineness(float local) const;
    Differences usual(float fineness) const;
  };
  /// Rings around the faces of a patch that their inputs depend on.
  static constexpr std::uint32_t kRings = 20;

  /// Offsets are told in mean edge lengths.
  explicit NormalFields(double mean_edge) : mean_edge_(static_cast<float>(mean_edge)) {}

  /// The fields of a patch that has kRings rings, from positions. False when stopped.
  bool measure(const FacePatch& patch, std::span<const SimdVec3> positions);
  /// Only what differences() needs. False when stopped.
  bool measure_differences(const FacePatch& patch, std::span<const SimdVec3> positions);
  /// Gives their memory back until they are measured again.
  void release();

  /// The patch's own faces; below, `face` counts them.
  std::size_t size() const { return patch_->own(); }
  /// The face of the mesh.
  Index number(std::size_t face) const { return patch_->face(face); }
  SimdVec3 field(std::size_t number, std::size_t face) const { return fields_[face][number]; }
  /// Whose means over the mesh are Whole.
  Differences differences(std::size_t face) const;
  /// Twice the area of the triangles around the face, as seen along smoothed normals, so that noise does not
  /// enlarge them: averaged over two rings.
  float local_area(std::size_t face) const { return local_areas_[face]; }
  /// Of `count` faces from `first` on, 1 to kTogether; what further lanes hold means nothing. Thread-safe.
  void describe(std::size_t first, std::size_t count, const Whole& whole, Inputs& inputs) const;
  /// The unit normal along the weighted sum of the fields.
  SimdVec3 blend(std::size_t face, const Weights& weights) const;

 private:
  using Field = Buffer<SimdVec3>;
  struct Kept {
    std::uint32_t steps;
    std::size_t field;
  };
  /// Rings of the means over regions, which need some of the fields so far out, and of one choice of a patch.
  static constexpr std::uint32_t kRegionRings = 6, kPatchRings = 2, kAreaRings = 2;

  bool start(const FacePatch& patch, std::span<const SimdVec3> positions);
  bool copy(std::size_t field, Field& to, std::uint32_t rings);
  bool keep(std::size_t field, const Field& from, std::uint32_t rings);
  template <class Weight>
  bool average(const Field& from, Field& to, std::uint32_t rings, Weight&& weight);
  template <class Weight>
  bool filter(std::initializer_list<Kept> kept, Weight&& weight);
  bool widen();
  bool narrow(float threshold, std::initializer_list<Kept> kept);
  bool most_even_patch(const Field& from, Field& to, std::uint32_t rings);
  bool choose_patches();
  bool mean_centroids();
  bool measure_local_areas();
  bool measure_regions();
  template <class Value>
  bool average_over_rings(std::uint32_t rings, Buffer<Value>& values, Buffer<Value>& next);

  std::span<const Index> neighbours(std::size_t face) const { return patch_->neighbours(face); }
  const RunControl& run() const { return patch_->mesh().run(); }

  /// Calls act() with every buffer.
  template <class Act>
  void for_each_buffer(Act&& act) {
    const auto each = [&](auto&... buffers) { (act(buffers), ...); };
    each(twice_areas_, centroids_, now_, next_, means_, evenness_, local_areas_, near_centroids_,
         far_centroids_, fields_, regions_, next_regions_);
  }

  const float mean_edge_;
  const FacePatch* patch_ = nullptr;
  Buffer<float> twice_areas_;
  Field centroids_, now_, next_, means_;
  Buffer<float> evenness_, local_areas_;
  Buffer<SimdVec3> near_centroids_, far_centroids_;  // means over one and three rings
  Buffer<std::array<SimdVec3, kFields>> fields_;
  Buffer<SimdVec3::Lanes> regions_, next_regions_;
};

}  // namespace burnish
