// A PLY file in memory: its bytes, and where in them the numbers stand that smoothing may change.
#pragma once

#include <array>

#include "core/io/normal_rows.h"
#include "core/io/ply.h"
#include "core/io/ply_header.h"

namespace burnish {

class PlyDocument final : public Document {
 public:
  PlyDocument(std::string_view bytes, PlyHeader header)
      : Document(Format::Ply), bytes_(bytes), header_(std::move(header)) {}

  std::string vertex_place(Index vertex) const override;
  std::string triangle_place(Index triangle) const override;
  Result<std::vector<Index>> attribute_vertices(std::string_view name, const RunControl& run) const override;
  Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                              const RunControl& run) const override;
  Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                             const RunControl& run) const override;

 private:
  friend class PlyReader;

  /// Three or two properties of the vertices that belong together.
  using Names = std::span<const std::string_view>;
  using Columns = std::vector<std::vector<float>>;

  const PlyElement& vertices() const { return header_.elements[vertex_element_]; }
  std::uint64_t vertex_row(Index vertex) const {
    return vertex_rows_.empty() ? begins_[vertex_element_] + vertex * vertices().least_bytes
                                : vertex_rows_[vertex];
  }
  std::string place(std::uint64_t offset) const;

  /// The values of scalar properties of the vertices, a column each.
  Result<Columns> read_columns(Names names, const RunControl& run) const;
  bool has_normals() const;
  Result<> patch_binary(const MovedPositions& moved, const NormalRows& normals, std::string& out,
                        double& error, const RunControl& run) const;
  Result<std::string> patch_text(const MovedPositions& moved, const NormalRows& normals, bool& any_moved,
                                 const RunControl& run) const;
  Result<NormalRows> recompute_normals(const MovedPositions& moved, const RunControl& run) const;
  Result<std::optional<MeshAttribute>> face_textures(const RunControl& run) const;
  void list_dropped(std::vector<std::string_view> used, bool textures, SharedAttributes& shared) const;

  std::string_view bytes_;
  PlyHeader header_;
  std::size_t vertex_element_ = 0, face_element_ = 0;  // elements.size() when there is none
  std::vector<std::uint64_t> begins_;                  // where each element's rows begin
  std::vector<std::uint64_t> vertex_rows_;             // where each does; empty when all have one size
  std::vector<Index> face_of_triangle_;                // empty when every face is a triangle
  std::size_t face_triangles_ = 0;                     // those behind them are of strips
};

}  // namespace burnish
