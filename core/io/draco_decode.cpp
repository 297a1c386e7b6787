#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>

#include <string>

#include "core/io/draco_document.h"
#include "core/io/draco_guard.h"
#include "core/io/draco_header.h"

namespace burnish {
namespace {

constexpr int kMostAttributes = 120;  // the encoder counts them in a signed byte
constexpr int kMostComponents = 127;  // so does its conversion of integers
constexpr std::uint64_t kMostAttributeBytes = std::uint64_t{1} << 31;  // the library's offsets are 32 bit

/// Memory that decoding may take, against the file's size and against the limit of it.
constexpr std::uint64_t kMostPerByte = 8192, kMostPerLimit = 64;

/// What must hold at each stage of decoding before the library goes on to the next.
class Admission {
 public:
  Admission(std::size_t file_bytes, DracoMethod method, const Limits& limits, const RunControl& run)
      : file_bytes_(file_bytes), method_(method), limits_(limits), run_(run) {}

  /// What the file declares ahead of `buffer`: the library allocates by it before it reads on.
  Result<> declared(const draco::DecoderBuffer& buffer) const {
    const auto declared = declared_counts(buffer, method_);
    return declared ? counts(declared->triangles, declared->points, 0) : Result<>{};
  }

  Result<> connectivity(const draco::Mesh& mesh) const {
    if (auto ok = counts(mesh.num_faces(), mesh.num_points(), 0); !ok) return ok;
    const Index points = mesh.num_points();
    Index culprit = kNone, missing = 0;
    const bool done = for_each_index(mesh.num_faces(), run_, [&](Index t) {
      for (const draco::PointIndex& p : mesh.face(draco::FaceIndex(t))) {
        if (p.value() >= points && culprit == kNone) culprit = t, missing = p.value();
      }
    });
    if (!done) return run_.stop_error();
    if (culprit == kNone) return {};
    return Error{Cause::IndexOutOfRange, "triangle " + std::to_string(culprit) + " uses point " +
                                             std::to_string(missing) + " of " + std::to_string(points)};
  }

  /// The attributes are declared, their values not yet read.
  Result<> attributes(const draco::Mesh& mesh) const {
    if (static_cast<std::uint32_t>(mesh.num_attributes()) > limits_.max_attributes) {
      return Error{Cause::TooLarge, "the mesh has " + std::to_string(mesh.num_attributes()) +
                                        " attributes; the limit is " +
                                        std::to_string(limits_.max_attributes) + " (max-attributes)"};
    }
    if (mesh.num_attributes() > kMostAttributes) {
      return Error{Cause::UnsupportedFormat, "the mesh has " + std::to_string(mesh.num_attributes()) +
                                                 " attributes; at most " + std::to_string(kMostAttributes) +
                                                 " can be carried"};
    }
    std::uint64_t point_bytes = 0;
    for (int id = 0; id < mesh.num_attributes(); ++id) {
      const draco::PointAttribute& attribute = *mesh.attribute(id);
      const int components = attribute.num_components();
      if (components > kMostComponents) {
        return Error{Cause::UnsupportedFormat, "attribute " + std::to_string(id) + " has " +
                                                   std::to_string(components) + " components; at most " +
                                                   std::to_string(kMostComponents) + " can be carried"};
      }
      const std::uint64_t value_bytes =
          static_cast<std::uint64_t>(components) *
          static_cast<std::uint64_t>(draco::DataTypeLength(attribute.data_type()));
      if (value_bytes * mesh.num_points() >= kMostAttributeBytes) {
        return Error{Cause::TooLarge, "attribute " + std::to_string(id) + " takes 2 GiB or more"};
      }
      point_bytes += value_bytes + sizeof(std::int32_t) * static_cast<std::uint64_t>(components);
    }
    if (auto ok = position_attribute(mesh); !ok) return ok;
    return counts(mesh.num_faces(), mesh.num_points(), point_bytes);
  }

 private:
  Result<> counts(std::uint64_t triangles, std::uint64_t points, std::uint64_t point_bytes) const {
    if (triangles > limits_.max_triangles) {
      return Error{Cause::TooLarge, "the mesh has " + std::to_string(triangles) +
                                        " triangles; the limit is " + std::to_string(limits_.max_triangles) +
                                        " (max-triangles)"};
    }
    if (points > limits_.max_vertices) {
      return Error{Cause::TooLarge, "the mesh has " + std::to_string(points) + " points; the limit is " +
                                        std::to_string(limits_.max_vertices) + " (max-vertices)"};
    }
    // A few bytes can declare millions of triangles: bound what decoding takes by what the file is worth. A
    // plane of a million triangles at 10 bits, the best that the encoder does, takes 4400 times its file.
    const std::uint64_t working_set = method_ == DracoMethod::Sequential ? 24 : 64;
    const std::uint64_t need = triangles * working_set + points * (24 + point_bytes);
    constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{256} << 20;
    if (need > kAlwaysAllowed &&
        (need / kMostPerByte > file_bytes_ || need / kMostPerLimit > limits_.max_bytes)) {
      return Error{Cause::TooLarge, "decoding " + std::to_string(file_bytes_) + " bytes would take " +
                                        std::to_string(need >> 20) + " MiB of memory; the limit is " +
                                        std::to_string(kMostPerByte) + " times the file and " +
                                        std::to_string(kMostPerLimit) + " times (max-bytes)"};
    }
    return run_.check();
  }

  static Result<> position_attribute(const draco::Mesh& mesh) {
    const int count = mesh.NumNamedAttributes(draco::GeometryAttribute::POSITION);
    if (count != 1) {
      return Error{Cause::UnsupportedFormat,
                   "the mesh has " + std::to_string(count) + " position attributes instead of one"};
    }
    const draco::PointAttribute& position = *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    if (position.data_type() == draco::DT_FLOAT32 && position.num_components() == 3) return {};
    return Error{Cause::UnsupportedFormat,
                 "positions must be 3 floats of 32 bits; these are " +
                     std::to_string(position.num_components()) + " components of " +
                     std::to_string(8 * draco::DataTypeLength(position.data_type())) + " bits"};
  }

  std::size_t file_bytes_;
  DracoMethod method_;
  const Limits& limits_;
  const RunControl& run_;
};

/// The library's decoder with our checks between its stages. Its own wrapper draco::Decoder would touch
/// foreign indices unchecked, and forgets the quantisation grid.
template <class Base>
class GuardedDecoder final : public Base {
 public:
  explicit GuardedDecoder(const Admission& admission) : admission_(admission) {}

  Result<> decode(std::string_view bytes, draco::Mesh& mesh) {
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    const draco::Status status = this->Decode(options_, &buffer, &mesh);
    if (refusal_) return *refusal_;
    if (status.ok()) return {};
    const bool version = status.code() == draco::Status::UNKNOWN_VERSION;
    return Error{version ? Cause::UnsupportedFormat : Cause::MalformedMesh,
                 "not a Draco mesh that can be read: " + status.error_msg_string()};
  }

 protected:
  bool DecodeConnectivity() override {
    return passes(admission_.declared(*this->buffer())) && Base::DecodeConnectivity() &&
           passes(admission_.connectivity(*this->mesh()));
  }
  bool CreateAttributesDecoder(std::int32_t id) override {
    if (!Base::CreateAttributesDecoder(id)) return false;
    auto guard = guarded(this->attributes_decoder(id));
    return guard && this->SetAttributesDecoder(id, std::move(guard));
  }
  bool DecodeAllAttributes() override {
    return passes(admission_.attributes(*this->mesh())) && Base::DecodeAllAttributes();
  }

 private:
  bool passes(const Result<>& verdict) {
    if (!verdict) refusal_ = verdict.error();
    return verdict.ok();
  }

  const Admission& admission_;
  draco::DecoderOptions options_;
  std::optional<Error> refusal_;
};

DracoCoding coding_of(const draco::PointAttribute* portable) {
  if (portable == nullptr) return {};
  if (draco::AttributeQuantizationTransform grid; grid.InitFromAttribute(*portable)) {
    return {grid.quantization_bits(), DracoGrid(grid.quantization_bits(), grid.min_values(), grid.range())};
  }
  if (draco::AttributeOctahedronTransform octahedron; octahedron.InitFromAttribute(*portable)) {
    return {octahedron.quantization_bits(), std::nullopt};
  }
  return {};
}

template <class Base>
Result<std::vector<DracoCoding>> decode_with(std::string_view bytes, const Admission& admission,
                                             draco::Mesh& mesh) {
  GuardedDecoder<Base> decoder(admission);
  if (auto ok = decoder.decode(bytes, mesh); !ok) return ok.error();
  std::vector<DracoCoding> codings;
  codings.reserve(static_cast<std::size_t>(mesh.num_attributes()));
  for (int id = 0; id < mesh.num_attributes(); ++id)
    codings.push_back(coding_of(decoder.GetPortableAttribute(id)));
  return codings;
}

/// Every point must lead to a value of every attribute.
Result<> check_values(const draco::Mesh& mesh, const RunControl& run) {
  for (int id = 0; id < mesh.num_attributes(); ++id) {
    const draco::PointAttribute& attribute = *mesh.attribute(id);
    const std::size_t mapped =
        attribute.is_mapping_identity() ? attribute.size() : attribute.indices_map_size();
    Index culprit = mapped < mesh.num_points() ? static_cast<Index>(mapped) : kNone;
    const bool done = for_each_index(std::min<std::size_t>(mapped, mesh.num_points()), run, [&](Index point) {
      if (value_of(attribute, point).value() >= attribute.size()) culprit = std::min(culprit, point);
    });
    if (!done) return run.stop_error();
    if (culprit != kNone) {
      return Error{Cause::MalformedMesh,
                   "point " + std::to_string(culprit) + " has no value in attribute " + std::to_string(id)};
    }
  }
  return {};
}

Result<std::unique_ptr<Document>> read_document(std::string_view bytes, DracoMethod method,
                                                const Limits& limits, const RunControl& run) {
  const Admission admission(bytes.size(), method, limits, run);
  auto mesh = std::make_unique<draco::Mesh>();
  auto codings = method == DracoMethod::Sequential
                     ? decode_with<draco::MeshSequentialDecoder>(bytes, admission, *mesh)
                     : decode_with<draco::MeshEdgebreakerDecoder>(bytes, admission, *mesh);
  if (!codings) return codings.error();
  if (auto ok = check_values(*mesh, run); !ok) return ok.error();

  const draco::PointAttribute& attribute = *mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  std::vector<Vec3d> positions(mesh->num_points());
  std::vector<Triangle> triangles(mesh->num_faces());
  const bool done = for_each_index(positions.size(), run,
                                   [&](Index p) {
                                     const auto v = attribute.GetValue<float, 3>(value_of(attribute, p));
                                     positions[p] = {v[0], v[1], v[2]};
                                   }) &&
                    for_each_index(triangles.size(), run, [&](Index t) {
                      const auto& face = mesh->face(draco::FaceIndex(t));
                      triangles[t] = {face[0].value(), face[1].value(), face[2].value()};
                    });
  if (!done) return run.stop_error();

  auto document = std::make_unique<DracoDocument>(std::move(mesh), method, *std::move(codings),
                                                  std::move(positions), std::move(triangles));
  const auto check = check_mesh(
      document->positions(), document->triangles(), [&](Index v) { return document->vertex_place(v); },
      [&](Index t) { return document->triangle_place(t); });
  if (!check) return check.error();
  return std::unique_ptr<Document>(std::move(document));
}

}  // namespace

Result<std::unique_ptr<Document>> decode_draco(std::string_view bytes, const Limits& limits,
                                               const RunControl& run) {
  if (bytes.size() > limits.max_bytes) {
    return Error{Cause::TooLarge, "the file has " + std::to_string(bytes.size()) + " bytes; the limit is " +
                                      std::to_string(limits.max_bytes) + " (max-bytes)"};
  }
  const auto method = draco_method(bytes);
  if (!method) return method.error();
  if (auto ok = run.check(); !ok) return ok.error();
  return without_exceptions(Cause::MalformedMesh, [&] { return read_document(bytes, *method, limits, run); });
}

}  // namespace burnish
