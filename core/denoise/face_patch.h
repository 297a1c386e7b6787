// A part of a mesh with the rings of faces around it, numbered anew: what looks far around every face can
// then be computed part by part, in memory that does not grow with the mesh.
#pragma once

#include <span>
#include <vector>

#include "core/run/buffer.h"
#include "core/smooth/normal_filter.h"

namespace burnish {

class FacePatch {
 public:
  /// `faces` says who is next to whom, and must outlive the patch.
  explicit FacePatch(const Faces& faces) : mesh_(faces) {}

  /// Takes the faces `own` of the mesh and so many rings of neighbours around them. False when stopped.
  bool surround(std::span<const Index> own, std::uint32_t rings);

  /// Faces within so many rings of the own ones, which come first.
  std::size_t within(std::uint32_t rings) const { return ends_[rings]; }
  std::size_t own() const { return ends_.front(); }
  std::size_t size() const { return ends_.back(); }
  /// The face of the mesh.
  Index face(std::size_t local) const { return faces_[local]; }
  /// Of a face that is not in the last ring, or of any when the patch is all of the mesh; in the order of
  /// Faces::for_each_neighbour.
  std::span<const Index> neighbours(std::size_t local) const {
    return std::span(items_).subspan(offsets_[local], offsets_[local + 1] - offsets_[local]);
  }
  const Faces& mesh() const { return mesh_; }

 private:
  bool grow();
  bool list_neighbours();

  const Faces& mesh_;
  std::vector<Index> local_;  // by face of the mesh; kNone: not in the patch
  std::vector<Index> faces_, ends_;
  Buffer<std::size_t> offsets_;
  Buffer<Index> items_;
};

}  // namespace burnish
