// Private to the GLB codec: a decoded file.
#pragma once

#include <array>

#include "core/io/draco_document.h"
#include "core/io/glb.h"
#include "core/io/glb_file.h"
#include "core/io/normal_rows.h"

namespace burnish {

/// Where the positions of one or more primitives stand: an accessor, or the points of a Draco bitstream.
struct GlbVertices {
  GlbAccessor positions = {};  ///< of a Draco bitstream its number alone
  Index first = 0, count = 0;  ///< in the document's vertices
  Index primitive = 0;         ///< the first that cites them
  Index part = 0;              ///< see Document::parts()
  // Of a Draco bitstream:
  std::unique_ptr<DracoDocument> draco = {};
  Index view = kNone;
  GlbView place = {};
  std::vector<Index> counting = {};          ///< accessors that state the number of its points
  std::vector<Index> counting_corners = {};  ///< and of its triangles' corners
  bool ordered = false;                      ///< something else of the file counts on the order of its points
};

/// Normals beside those vertices: an accessor, or an attribute of the Draco mesh.
struct GlbNormals {
  GlbAccessor accessor = {};
  int draco_attribute = -1;                  ///< of the vertices' Draco mesh
  Index vertices = 0, first = 0, count = 0;  ///< first: among all normals of the document
  bool shared = false;                       ///< with other vertices: these are not recomputed
};

struct GlbPrimitive {
  Index mesh = 0, number = 0;  ///< in the file
  Index vertices = 0, normals = kNone;
  Index first_triangle = 0, triangles = 0;
  const JsonValue* json = nullptr;
};

/// What smoothing passes over, for warnings.
struct GlbPassedOver {
  Index primitives = 0, tangents = 0, targets = 0, normals = 0;
  std::string first_primitive = {}, first_tangents = {}, first_targets = {}, first_normals = {};
};

class GlbDocument final : public Document {
 public:
  explicit GlbDocument(GlbFile file) : Document(Format::Glb), file_(std::move(file)) {}

  std::string vertex_place(Index vertex) const override;
  std::string triangle_place(Index triangle) const override;
  Result<std::vector<Index>> group_vertices(std::string_view name, const RunControl& run) const override;
  Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                              const RunControl& run) const override;
  Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                             const RunControl& run) const override;

  const GlbFile& file() const { return file_; }
  std::span<const GlbVertices> vertices() const { return vertices_; }
  std::span<const GlbNormals> normals() const { return normals_; }
  std::span<const GlbPrimitive> primitives() const { return primitives_; }
  const GlbPassedOver& passed_over() const { return passed_over_; }

  /// "mesh 0 "body", primitive 1"
  std::string place_of(const GlbPrimitive& primitive) const;

  /// Every normal of the file, recomputed for the moved positions; elements are counted by GlbNormals::first.
  Result<NormalRows> moved_normals(const MovedPositions& moved, const RunControl& run) const;
  /// The normal of each corner, or kNone.
  std::vector<Triangle> corner_normals() const;

 private:
  friend class GlbReader;

  GlbFile file_;
  std::vector<GlbVertices> vertices_;
  std::vector<GlbNormals> normals_;
  std::vector<GlbPrimitive> primitives_;
  GlbPassedOver passed_over_;
};

/// "mesh 0 "body", primitive 1"
std::string glb_place(const GlbFile& file, Index mesh, Index primitive);

/// A row of an accessor as numbers: normalised integers as the fractions that they stand for.
Vec3d read_row(const GlbFile& file, const GlbAccessor& accessor, std::uint64_t row);

/// The attribute of a Draco mesh that an extension's `attributes` name by its unique id; -1: none.
int glb_draco_attribute(const draco::Mesh& mesh, const JsonValue& ids, std::string_view semantic);

}  // namespace burnish
