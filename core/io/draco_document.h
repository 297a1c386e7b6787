// Private to the Draco codec: a decoded file, and what its two encoders share.
#pragma once

#include <draco/mesh/mesh.h>

#include <algorithm>
#include <new>
#include <optional>

#include "core/io/draco.h"
#include "core/io/draco_grid.h"
#include "core/io/normal_rows.h"
#include "core/run/parallel.h"

namespace burnish {

/// How the input stored one attribute.
struct DracoCoding {
  int bits = 0;                   ///< 0 = lossless; for normals, of the octahedral coordinates
  std::optional<DracoGrid> grid;  ///< of quantised attributes that are not octahedral
};

/// Vertices are Draco's points, counted from 0 as Draco does; points that share a position value repeat it.
class DracoDocument final : public Document {
 public:
  /// `codings` has one entry per attribute of `mesh`, which has passed every check of decode_draco().
  DracoDocument(std::unique_ptr<const draco::Mesh> mesh, DracoMethod method, std::vector<DracoCoding> codings,
                std::vector<Vec3d> positions, std::vector<Triangle> triangles);

  std::string vertex_place(Index vertex) const override { return "point " + std::to_string(vertex); }
  std::string triangle_place(Index triangle) const override { return "triangle " + std::to_string(triangle); }
  Result<std::vector<Index>> attribute_vertices(std::string_view name, const RunControl& run) const override;

  Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                              const RunControl& run) const override;
  Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                             const RunControl& run) const override;

  const draco::Mesh& mesh() const { return *mesh_; }
  DracoMethod method() const { return method_; }
  std::span<const DracoCoding> codings() const { return codings_; }

 private:
  std::unique_ptr<const draco::Mesh> mesh_;
  DracoMethod method_;
  std::vector<DracoCoding> codings_;
};

/// Normals of a normal attribute with 3 components, an element a point, recomputed where a triangle that uses
/// them moved.
Result<NormalRows> recompute_normals(const draco::PointAttribute& attribute, const MovedPositions& moved,
                                     std::span<const Triangle> triangles, const RunControl& run);

/// Moves the positions of `mesh`, whose first points are the vertices of `moved`, and writes it. `inherited`
/// has one entry per attribute. Errors: CannotEncode, BadOption, Cancelled, DeadlineExceeded.
Result<Encoded> write_draco(draco::Mesh& mesh, const MovedPositions& moved,
                            std::span<const DracoCoding> inherited, DracoMethod method,
                            const DracoOptions& options, const RunControl& run);

/// Calls the library's encoder. `mesh` has passed every check; `codings` has one entry per attribute.
struct DracoFile {
  std::string bytes;
  std::size_t points = 0, triangles = 0;  ///< that Edgebreaker wrote; 0 for sequential
};
Result<DracoFile> encode_with_library(const draco::Mesh& mesh, std::span<const DracoCoding> codings,
                                      DracoMethod method, int speed, const RunControl& run);

/// Calls body(i) for 0 .. count - 1 in order on this thread. False when stopped half-way.
template <class Body>
bool for_each_index(std::size_t count, const RunControl& run, Body&& body) {
  for (std::size_t begin = 0; begin < count; begin += kBlockSize) {
    if (run.stopped()) return false;
    const std::size_t end = std::min(count, begin + kBlockSize);
    for (std::size_t i = begin; i < end; ++i) body(static_cast<Index>(i));
  }
  return true;
}

/// Runs `work` and turns what the library may throw into an Error: memory, and `otherwise` for the rest.
template <class Work>
auto without_exceptions(Cause otherwise, Work&& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "not enough memory for this Draco mesh"};
  } catch (const std::exception& e) {
    return Error{otherwise, std::string("the Draco library gave up: ") + e.what()};
  }
}

inline draco::AttributeValueIndex value_of(const draco::PointAttribute& attribute, Index point) {
  return attribute.mapped_index(draco::PointIndex(point));
}

}  // namespace burnish
