// An OBJ file in memory: its text, and where in it the numbers stand that smoothing may change.
#pragma once

#include "core/io/obj.h"
#include "core/io/text_scan.h"

namespace burnish {

class ObjDocument final : public Document {
 public:
  ObjDocument() : Document(Format::Obj) {}

  std::string vertex_place(Index vertex) const override;
  std::string triangle_place(Index triangle) const override;
  Result<std::vector<Index>> group_vertices(std::string_view name, const RunControl& run) const override;
  Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                              const RunControl& run) const override;
  Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                             const RunControl& run) const override;

 private:
  friend class ObjParser;

  std::string_view text_;
  std::vector<TextRange> vertex_text_;     // "x y z" of each v line
  std::vector<TextRange> normal_text_;     // "x y z" of each vn line
  std::vector<TextRange> texture_text_;    // everything after "vt"
  std::vector<Triangle> corner_normals_;   // per triangle; empty when no face cites a normal
  std::vector<Triangle> corner_textures_;  // likewise
  std::vector<Index> face_of_triangle_;    // empty when every face is a triangle
  bool has_more_ = false;                  // groups, materials, lines... that only OBJ can carry
};

}  // namespace burnish
