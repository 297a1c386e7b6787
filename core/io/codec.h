// Bytes to Document to bytes. A Document remembers everything about the file that it came from, so that
// writing it back changes moved positions and recomputed normals only.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/format.h"
#include "core/mesh/surface.h"

namespace burnish {

enum class DracoMethod : std::uint8_t { Sequential, Edgebreaker };

/// How to write Draco. Unset means: as in the input; for any other input sequential, lossless, speed 5.
struct DracoOptions {
  std::optional<DracoMethod> method = {};
  /// Bits per component, 1 to 30; 0 = lossless floats. Normals: octahedral, 2 to 30 or 0.
  std::optional<int> position_bits = {}, normal_bits = {}, texture_coordinate_bits = {}, color_bits = {},
                     generic_bits = {};
  std::optional<int> speed = {};  ///< 0 (smallest) to 10 (fastest), for encoding and decoding
};

struct OutputOptions {
  std::optional<Format> format = {};  ///< unset: the input's
  DracoOptions draco = {};
  std::uint64_t part_bytes = std::uint64_t{1} << 20;  ///< text that a thread writes at once; changes no byte
};

/// Values per corner or per vertex of a mesh, for carrying them into another format.
struct MeshAttribute {
  int components = 0;
  std::vector<float> values;      ///< components per row
  std::vector<Triangle> corners;  ///< row of each triangle corner; kNone where the file gives none
};

/// The attributes that more than one format knows.
struct SharedAttributes {
  std::optional<MeshAttribute> normals;              ///< 3 components
  std::optional<MeshAttribute> texture_coordinates;  ///< 2 components
  std::vector<float> colors;                         ///< r, g, b in [0, 1] per file vertex; empty when none
  std::vector<std::string> dropped;                  ///< what else the file holds and the other format cannot
};

/// What a file may hold. An error that says so names the member as its flag is spelt: "(max-vertices)".
struct Limits {
  std::uint64_t max_bytes = std::uint64_t{256} << 20;
  std::uint64_t max_vertices = 20'000'000;
  std::uint64_t max_triangles = 40'000'000;
  std::uint32_t max_attributes = 64;  ///< of a Draco mesh; elements and properties of a PLY
  std::uint64_t max_line_bytes = std::uint64_t{1} << 20;  ///< of text
};

/// The written file and how true it is.
struct Encoded {
  std::string bytes;
  Format format = Format::Obj;
  std::optional<DracoMethod> draco_method;
  int position_bits = 0;  ///< 0 = lossless
  double quantisation_error =
      0;  ///< largest distance between a smoothed position and the one written, file unit
  /// Counts in the written file, where they can differ from the document's (seam copies, Edgebreaker).
  std::optional<std::uint32_t> vertices, triangles;
  std::vector<Warning> warnings;
};

/// A decoded file. Immutable once decode() returned it; safe to read from many threads.
class Document {
 public:
  virtual ~Document() = default;

  Format format() const { return format_; }
  /// Whether the file is text behind a byte order mark, which encode() puts there again.
  bool has_byte_order_mark() const { return has_byte_order_mark_; }
  std::span<const Vec3d> positions() const { return positions_; }     ///< file order, file unit
  std::span<const Triangle> triangles() const { return triangles_; }  ///< polygons as fans, file order

  /// For each vertex the part of the file that it is in: equal positions are one vertex within a part only,
  /// see prepare_surface(). Empty: the file is one part.
  std::span<const Index> parts() const { return parts_; }

  virtual std::string vertex_place(Index vertex) const = 0;      ///< "vertex 12 (line 40)"
  virtual std::string triangle_place(Index triangle) const = 0;  ///< "triangle 812 (line 10321)"

  /// For pin_vertices(): vertices of an OBJ's faces in the group `name` (`g a b`: in both; faces before the
  /// first `g`, or after one without a name, are in "default"); points of a Draco mesh where a component of
  /// an attribute is not 0, which `name` names by its metadata entry "name" or else by its unique id;
  /// vertices of a PLY whose property `name` is not 0. The groups of a GLB are
  /// its meshes, by their names (or else numbers) or the names of nodes that place them. Ascending, each
  /// once. Errors: BadOption, listing what there is or saying that the format has none; Cancelled,
  /// DeadlineExceeded.
  virtual Result<std::vector<Index>> group_vertices(std::string_view name, const RunControl& run) const;
  virtual Result<std::vector<Index>> attribute_vertices(std::string_view name, const RunControl& run) const;

  /// Writes the same format back, without a byte order mark. `options.format` is ignored.
  virtual Result<Encoded> encode_same(const MovedPositions& moved, const OutputOptions& options,
                                      const RunControl& run) const = 0;
  /// What can be carried into another format, with normals recomputed for the moved positions.
  virtual Result<SharedAttributes> shared_attributes(const MovedPositions& moved,
                                                     const RunControl& run) const = 0;

 protected:
  explicit Document(Format format) : format_(format) {}
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  Format format_;
  std::vector<Vec3d> positions_;
  std::vector<Triangle> triangles_;
  std::vector<Index> parts_;

 private:
  friend Result<std::unique_ptr<Document>> decode(std::string_view, std::optional<Format>, const Limits&,
                                                  const RunControl&);
  bool has_byte_order_mark_ = false;
};

/// Decodes and checks. `bytes` must stay alive and unchanged as long as the Document. `format` unset:
/// detected. Errors: UnsupportedFormat, MalformedMesh, IndexOutOfRange, NonFinitePosition, EmptyMesh,
/// NotATriangleMesh, TooLarge, OutOfMemory, Cancelled, DeadlineExceeded.
Result<std::unique_ptr<Document>> decode(std::string_view bytes, std::optional<Format> format,
                                         const Limits& limits, const RunControl& run);

/// Writes a document with moved positions, in its own format or another.
/// Errors: CannotEncode, BadOption, Cancelled, DeadlineExceeded, OutOfMemory.
Result<Encoded> encode(const Document& document, const MovedPositions& moved, const OutputOptions& options,
                       const RunControl& run);

/// Writes any mesh as a new file. What the format has no place for is left out, with a warning that names it
/// together with attributes.dropped. `options.format` is ignored. Errors: those of encode().
Result<Encoded> encode_as(Format format, const MovedPositions& moved, std::span<const Triangle> triangles,
                          SharedAttributes attributes, const OutputOptions& options, const RunControl& run);

}  // namespace burnish
