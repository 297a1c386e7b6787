// The fields of normals of a whole mesh, patch by patch, so that only those of one patch are in memory.
#pragma once

#include <functional>
#include <optional>

#include "core/denoise/normal_fields.h"

namespace burnish {

class NormalPatches {
 public:
  /// Faces per patch: the rings around so many cost about a fifth more work, and the fields of them 70 MB.
  static constexpr std::size_t kMostFaces = 131'072;
  using Visit = std::function<bool(const NormalFields& fields)>;

  NormalPatches(const Surface& surface, const Faces& faces, const RunControl& run,
                std::size_t most_faces = kMostFaces);

  /// Measures the mesh's patches one after the other and calls visit() for each; the numbers do not depend on
  /// how the mesh was parted. The means over the whole mesh are those of the first call: later ones see a
  /// smoother mesh, and would not know any more how noisy it was. False when stopped or when visit() was.
  bool measure(std::span<const SimdVec3> positions, const Visit& visit);

  /// Of the first measure(); for NormalFields::describe().
  const NormalFields::Whole& whole() const { return *whole_; }

 private:
  /// Of a face of the mesh.
  struct Seen {
    NormalFields::Differences differences;
    float local_area;
  };

  bool take(std::size_t part);
  std::span<Index> own(std::size_t part);
  bool gather(std::span<Seen> seen) const;
  NormalFields::Whole fit(std::span<const Seen> seen) const;

  const Faces& faces_;
  const RunControl& run_;
  FacePatch patch_;
  NormalFields fields_;
  std::size_t parts_;
  std::vector<Index> order_;  // faces, part by part
  std::optional<std::size_t> taken_;
  std::optional<NormalFields::Whole> whole_;
};

}  // namespace burnish
