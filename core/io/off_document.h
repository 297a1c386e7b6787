// An OFF file in memory: its text, and where in it the vertices and faces stand.
#pragma once

#include "core/io/normal_rows.h"
#include "core/io/off.h"

namespace burnish {

class OffDocument final : public Document {
 public:
  explicit OffDocument(std::string_view text) : Document(Format::Off), text_(text) {}

  std::string vertex_place(Index vertex) const override;
  std::string triangle_place(Index triangle) const override;
  Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                              const RunControl& run) const override;
  Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                             const RunControl& run) const override;

 private:
  friend class OffReader;

  Result<NormalRows> recompute_normals(const MovedPositions& moved, const RunControl& run) const;
  Result<std::vector<float>> read_colors(const RunControl& run) const;

  std::string_view text_;
  std::vector<std::uint64_t> vertex_begins_;  // of each vertex' first word
  std::vector<std::uint64_t> face_begins_;
  std::vector<Index> face_of_triangle_;  // empty when every face is a triangle
  std::vector<Vec3f> normals_;           // of NOFF, per vertex
  bool has_colors_ = false, has_textures_ = false, has_face_colors_ = false, has_comments_ = false;
};

}  // namespace burnish
