#include <algorithm>
#include <numeric>

#include "core/io/glb_document.h"
#include "core/io/glb_overlap.h"
#include "core/io/pins.h"

namespace burnish {
namespace {

using Kind = JsonValue::Kind;

enum Mode : std::uint64_t { kTriangles = 4, kStrip = 5, kFan = 6 };

constexpr std::string_view kDraco = "KHR_draco_mesh_compression";

Error malformed(const std::string& what) { return {Cause::MalformedMesh, what}; }

Error led_by(const std::string& place, Error error) {
  error.message = place + ": " + error.message;
  return error;
}

const JsonValue* draco_extension(const JsonValue& primitive) {
  const JsonValue* const extensions = primitive.find("extensions");
  return extensions == nullptr ? nullptr : extensions->find(kDraco);
}

std::uint64_t triangles_of(std::uint64_t mode, std::uint64_t corners) {
  if (mode == kTriangles) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

/// Which of a primitive's corners make its triangle t.
std::array<std::uint64_t, 3> corners_of(std::uint64_t mode, std::uint64_t t) {
  if (mode == kTriangles) return {3 * t, 3 * t + 1, 3 * t + 2};
  if (mode == kFan) return {t + 1, t + 2, 0};
  return {t, t + 1 + t % 2, t + 2 - t % 2};
}

bool holds_positions(const GlbAccessor& accessor) {
  return accessor.components == 3 && accessor.component != GlbComponent::UInt32;
}

bool holds_normals(const GlbAccessor& accessor) {
  if (accessor.components != 3) return false;
  if (accessor.component == GlbComponent::Float) return true;
  return accessor.normalized &&
         (accessor.component == GlbComponent::Int8 || accessor.component == GlbComponent::Int16);
}

bool holds_indices(const GlbAccessor& accessor) {
  return accessor.components == 1 &&
         (accessor.component == GlbComponent::UInt8 || accessor.component == GlbComponent::UInt16 ||
          accessor.component == GlbComponent::UInt32);
}

}  // namespace

class GlbReader {
 public:
  GlbReader(GlbFile file, const Limits& limits, const RunControl& run)
      : document_(std::make_unique<GlbDocument>(std::move(file))),
        file_(document_->file()),
        limits_(limits),
        run_(run) {}

  Result<std::unique_ptr<Document>> read() {
    const JsonValue* const meshes = file_.json().find("meshes");
    const std::size_t count = meshes == nullptr ? 0 : meshes->items.size();
    for (std::size_t m = 0; m < count; ++m) {
      if (auto ok = read_mesh(meshes->items[m], static_cast<Index>(m)); !ok) return ok.error();
    }
    if (document_->primitives_.empty()) {
      return Error{Cause::EmptyMesh, "the GLB has no mesh with triangles"};
    }
    if (auto ok = separate(count); !ok) return ok.error();
    if (auto ok = read_positions(); !ok) return ok.error();
    const GlbDocument& document = *document_;
    const auto check = check_mesh(
        document.positions(), document.triangles(), [&](Index v) { return document.vertex_place(v); },
        [&](Index t) { return document.triangle_place(t); });
    if (!check) return check.error();
    return std::unique_ptr<Document>(std::move(document_));
  }

 private:
  Result<> read_mesh(const JsonValue& mesh, Index number) {
    const JsonValue* const primitives = mesh.find("primitives");
    if (primitives == nullptr || !primitives->is(Kind::Array)) {
      return malformed("meshes[" + std::to_string(number) + "] has no primitives");
    }
    for (const JsonValue& primitive : primitives->items) {
      if (auto ok = run_.check(); !ok) return ok;
      const auto p = static_cast<Index>(&primitive - primitives->items.data());
      if (auto ok = read_primitive({.mesh = number, .number = p, .json = &primitive}); !ok) return ok;
    }
    return {};
  }

  Result<> read_primitive(GlbPrimitive primitive) {
    const std::string place = document_->place_of(primitive);
    const JsonValue& json = *primitive.json;
    const auto mode = whole_member(json, "mode", place, kTriangles);
    if (!mode) return mode.error();
    if (*mode > kFan)
      return malformed(place + ".mode is " + std::to_string(*mode) + ", which glTF does not know");
    const JsonValue* const attributes = json.find("attributes");
    const JsonValue* const positions = attributes == nullptr ? nullptr : attributes->find("POSITION");
    if (*mode < kTriangles || positions == nullptr) {
      GlbPassedOver& passed = document_->passed_over_;
      if (passed.primitives++ == 0) passed.first_primitive = place;
      return {};
    }
    const auto vertices =
        draco_extension(json) != nullptr ? read_draco(primitive, place) : read_vertices(*positions, place);
    if (!vertices) return vertices.error();
    primitive.vertices = *vertices;
    primitive.first_triangle = static_cast<Index>(document_->triangles_.size());
    const bool compressed = document_->vertices_[*vertices].draco != nullptr;
    if (auto ok =
            compressed ? take_draco_triangles(*vertices, place) : read_triangles(primitive, *mode, place);
        !ok) {
      return ok;
    }
    primitive.triangles = static_cast<Index>(document_->triangles_.size()) - primitive.first_triangle;
    if (auto ok = read_normals(primitive, *attributes, place); !ok) return ok;
    note_what_stays(json, *attributes, place);
    document_->primitives_.push_back(primitive);
    return {};
  }

  Index next_primitive() const { return static_cast<Index>(document_->primitives_.size()); }

  Result<Index> add_vertices(GlbVertices vertices, std::uint64_t count) {
    const std::uint64_t first = document_->vertices_.empty()
                                    ? 0
                                    : document_->vertices_.back().first + document_->vertices_.back().count;
    if (first + count > limits_.max_vertices) {
      return Error{Cause::TooLarge, "the mesh has " + std::to_string(first + count) +
                                        " vertices or more; the limit is " +
                                        std::to_string(limits_.max_vertices) + " (max-vertices)"};
    }
    vertices.first = static_cast<Index>(first);
    vertices.count = static_cast<Index>(count);
    vertices.primitive = next_primitive();
    document_->vertices_.push_back(std::move(vertices));
    return static_cast<Index>(document_->vertices_.size() - 1);
  }

  /// Room for `more` triangles.
  Result<> admit_triangles(std::uint64_t more) {
    const std::uint64_t count = document_->triangles_.size() + more;
    if (count > limits_.max_triangles) {
      return Error{Cause::TooLarge, "the mesh has " + std::to_string(count) +
                                        " triangles or more; the limit is " +
                                        std::to_string(limits_.max_triangles) + " (max-triangles)"};
    }
    return {};
  }

  Result<Index> read_vertices(const JsonValue& number, const std::string& place) {
    const auto accessor = file_.accessor(number, "the positions of " + place);
    if (!accessor) return accessor.error();
    if (const auto known = by_accessor_.find(accessor->number); known != by_accessor_.end()) {
      return known->second;
    }
    if (!holds_positions(*accessor)) {
      return malformed("the positions of " + place + " must be VEC3 of floats, or of bytes or shorts");
    }
    const auto added = add_vertices({.positions = *accessor}, accessor->count);
    if (added) by_accessor_[accessor->number] = *added;
    return added;
  }

  Result<Index> read_draco(const GlbPrimitive& primitive, const std::string& place) {
    const JsonValue& extension = *draco_extension(*primitive.json);
    const JsonValue* const number = extension.find("bufferView");
    if (number == nullptr) return malformed(place + ": " + std::string(kDraco) + " has no bufferView");
    const auto view = file_.view(*number, "the compressed bytes of " + place);
    if (!view) return view.error();
    const auto view_number = static_cast<Index>(number->number);
    Index index = kNone;
    if (const auto known = by_view_.find(view_number); known != by_view_.end()) {
      index = known->second;
    } else {
      auto decoded =
          decode_draco(file_.buffer(view->buffer).substr(view->begin, view->length), limits_, run_);
      if (!decoded) return led_by(place, decoded.error());
      std::unique_ptr<DracoDocument> draco(static_cast<DracoDocument*>(decoded->release()));
      const std::size_t points = draco->positions().size();
      const auto added =
          add_vertices({.draco = std::move(draco), .view = view_number, .place = *view}, points);
      if (!added) return added.error();
      index = by_view_[view_number] = *added;
    }
    if (auto ok = cite_draco(primitive, extension, place, document_->vertices_[index]); !ok)
      return ok.error();
    return index;
  }

  /// What the primitive says of the compressed mesh, which has to change with it.
  Result<> cite_draco(const GlbPrimitive& primitive, const JsonValue& extension, const std::string& place,
                      GlbVertices& vertices) {
    const JsonValue* const ids = extension.find("attributes");
    const draco::Mesh& mesh = vertices.draco->mesh();
    const int position = mesh.GetNamedAttributeId(draco::GeometryAttribute::POSITION);
    if (ids == nullptr || glb_draco_attribute(mesh, *ids, "POSITION") != position) {
      return malformed(place + ": " + std::string(kDraco) +
                       ".attributes.POSITION is not the id of its positions");
    }
    const JsonValue* const targets = primitive.json->find("targets");
    vertices.ordered |= targets != nullptr && !targets->items.empty();
    for (const JsonValue& attribute : primitive.json->find("attributes")->items) {
      if (ids->find(attribute.name) == nullptr) {
        vertices.ordered = true;
        continue;
      }
      const auto number = compressed_accessor(attribute, place);
      if (!number) return number.error();
      vertices.counting.push_back(*number);
      if (attribute.name == "POSITION") vertices.positions.number = *number;
    }
    if (const JsonValue* const indices = primitive.json->find("indices"); indices != nullptr) {
      const auto number = compressed_accessor(*indices, place);
      if (!number) return number.error();
      vertices.counting_corners.push_back(*number);
    }
    return {};
  }

  /// An accessor that says what the compressed bytes hold, and holds nothing itself.
  Result<Index> compressed_accessor(const JsonValue& number, const std::string& place) {
    const auto found = file_.element("accessors", number, place + ", " + number.name);
    if (!found) return found.error();
    if (found->first->find("bufferView") == nullptr) return found->second;
    return Error{Cause::UnsupportedFormat,
                 place + " holds its " + number.name +
                     " twice, compressed and not, and both would have to stay alike; leave one of them out"};
  }

  Result<> take_draco_triangles(Index index, const std::string& place) {
    const GlbVertices& vertices = document_->vertices_[index];
    const auto faces = vertices.draco->triangles();
    if (auto ok = admit_triangles(faces.size()); !ok) return led_by(place, ok.error());
    for (const Triangle& t : faces) {
      document_->triangles_.push_back({t[0] + vertices.first, t[1] + vertices.first, t[2] + vertices.first});
    }
    return {};
  }

  Result<> read_triangles(const GlbPrimitive& primitive, std::uint64_t mode, const std::string& place) {
    const GlbVertices& vertices = document_->vertices_[primitive.vertices];
    const JsonValue* const number = primitive.json->find("indices");
    if (number == nullptr) {
      return add_triangles(mode, vertices.count, vertices, place,
                           [](std::uint64_t corner) { return corner; });
    }
    const auto indices = file_.accessor(*number, "the indices of " + place);
    if (!indices) return indices.error();
    if (!holds_indices(*indices)) {
      return malformed("the indices of " + place + " must be SCALAR of unsigned bytes, shorts or ints");
    }
    read_only_.push_back(*indices);
    const char* const data = file_.buffer(indices->buffer).data() + indices->begin;
    const auto read = [&](auto type) {
      return add_triangles(mode, indices->count, vertices, place, [&](std::uint64_t corner) {
        auto value = type;
        std::memcpy(&value, data + corner * indices->stride, sizeof value);
        return std::uint64_t{value};
      });
    };
    if (indices->component == GlbComponent::UInt8) return read(std::uint8_t{});
    if (indices->component == GlbComponent::UInt16) return read(std::uint16_t{});
    return read(std::uint32_t{});
  }

  template <class IndexAt>
  Result<> add_triangles(std::uint64_t mode, std::uint64_t corners, const GlbVertices& vertices,
                         const std::string& place, IndexAt index_at) {
    const std::uint64_t count = triangles_of(mode, corners);
    if (auto ok = admit_triangles(count); !ok) return led_by(place, ok.error());
    std::vector<Triangle>& all = document_->triangles_;
    const std::size_t first = all.size();
    all.resize(first + count);
    for (std::uint64_t t = 0; t < count; ++t) {
      if (t % kBlockSize == 0 && run_.stopped()) return run_.stop_error();
      const auto places = corners_of(mode, t);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint64_t index = index_at(places[c]);
        if (index >= vertices.count) {
          return Error{Cause::IndexOutOfRange, place + ": triangle " + std::to_string(t) + " uses vertex " +
                                                   std::to_string(index) + " of " +
                                                   std::to_string(vertices.count)};
        }
        all[first + t][c] = vertices.first + static_cast<Index>(index);
      }
    }
    return {};
  }

  Result<> read_normals(GlbPrimitive& primitive, const JsonValue& attributes, const std::string& place) {
    const GlbVertices& vertices = document_->vertices_[primitive.vertices];
    GlbNormals normals{.vertices = primitive.vertices, .count = vertices.count};
    const JsonValue* const number = attributes.find("NORMAL");
    if (number == nullptr) return {};
    bool readable = false;
    if (vertices.draco != nullptr) {
      const JsonValue* const ids = draco_extension(*primitive.json)->find("attributes");
      normals.draco_attribute = glb_draco_attribute(vertices.draco->mesh(), *ids, "NORMAL");
      if (normals.draco_attribute >= 0) {
        const auto& held = *vertices.draco->mesh().attribute(normals.draco_attribute);
        readable = held.data_type() == draco::DT_FLOAT32 && held.num_components() == 3;
      }
    } else {
      const auto accessor = file_.accessor(*number, "the normals of " + place);
      if (!accessor) return accessor.error();
      if (accessor->count != vertices.count) {
        return malformed(place + " has " + std::to_string(vertices.count) + " positions and " +
                         std::to_string(accessor->count) + " normals");
      }
      normals.accessor = *accessor;
      readable = holds_normals(*accessor);
    }
    if (readable) {
      const auto added = add_normals(normals);
      if (!added) return added.error();
      primitive.normals = *added;
    } else if (document_->passed_over_.normals++ == 0) {
      document_->passed_over_.first_normals = place;
    }
    return {};
  }

  Result<Index> add_normals(GlbNormals normals) {
    std::vector<GlbNormals>& all = document_->normals_;
    const bool compressed = normals.draco_attribute >= 0;
    const std::uint64_t name =
        compressed ? static_cast<std::uint64_t>(normals.draco_attribute) : normals.accessor.number;
    const auto [known, is_new] = by_normals_.try_emplace(
        name << 33 | std::uint64_t{compressed} << 32 | normals.vertices, static_cast<Index>(all.size()));
    if (!is_new) return known->second;
    if (!compressed) {
      const auto [user, first_user] =
          normals_user_.try_emplace(normals.accessor.number, static_cast<Index>(all.size()));
      if (!first_user) normals.shared = all[user->second].shared = true;
    }
    const std::uint64_t first = all.empty() ? 0 : std::uint64_t{all.back().first} + all.back().count;
    if (first + normals.count > limits_.max_vertices) {
      return Error{Cause::TooLarge, "the mesh has more normals than " + std::to_string(limits_.max_vertices) +
                                        " (max-vertices)"};
    }
    normals.first = static_cast<Index>(first);
    all.push_back(normals);
    return known->second;
  }

  void note_what_stays(const JsonValue& json, const JsonValue& attributes, const std::string& place) {
    GlbPassedOver& passed = document_->passed_over_;
    if (attributes.find("TANGENT") != nullptr && passed.tangents++ == 0) passed.first_tangents = place;
    const JsonValue* const targets = json.find("targets");
    if (targets != nullptr && !targets->items.empty() && passed.targets++ == 0) passed.first_targets = place;
  }

  /// Vertices move as one within a mesh, and within meshes that share vertices; here each such set of meshes
  /// gets its number.
  Result<> separate(std::size_t meshes) {
    std::vector<Index> leader(meshes);
    std::iota(leader.begin(), leader.end(), 0);
    const auto find = [&](Index mesh) {
      while (leader[mesh] != mesh) mesh = leader[mesh] = leader[leader[mesh]];
      return mesh;
    };
    const auto mesh_of = [&](Index vertices) {
      return document_->primitives_[document_->vertices_[vertices].primitive].mesh;
    };
    const auto unite = [&](Index a, Index b) {
      a = find(a), b = find(b);
      leader[std::max(a, b)] = std::min(a, b);
    };
    for (const GlbPrimitive& primitive : document_->primitives_)
      unite(primitive.mesh, mesh_of(primitive.vertices));
    if (auto ok =
            check_overlaps(*document_, read_only_, [&](Index a, Index b) { unite(mesh_of(a), mesh_of(b)); });
        !ok) {
      return ok;
    }
    bool several = false;
    for (GlbVertices& vertices : document_->vertices_) {
      vertices.part = find(document_->primitives_[vertices.primitive].mesh);
      several |= vertices.part != document_->vertices_.front().part;
    }
    if (!several) return {};
    for (const GlbVertices& vertices : document_->vertices_) {
      document_->parts_.insert(document_->parts_.end(), vertices.count, vertices.part);
    }
    return {};
  }

  Result<> read_positions() {
    for (const GlbVertices& vertices : document_->vertices_) {
      std::vector<Vec3d>& all = document_->positions_;
      if (vertices.draco != nullptr) {
        const auto points = vertices.draco->positions();
        all.insert(all.end(), points.begin(), points.end());
        continue;
      }
      all.resize(std::size_t{vertices.first} + vertices.count);
      const bool done = for_each(vertices.count, run_, [&](std::size_t row) {
        all[vertices.first + row] = read_row(file_, vertices.positions, row);
      });
      if (!done) return run_.stop_error();
    }
    return {};
  }

  std::unique_ptr<GlbDocument> document_;
  const GlbFile& file_;
  const Limits& limits_;
  const RunControl& run_;
  std::unordered_map<Index, Index> by_accessor_, by_view_, normals_user_;
  std::unordered_map<std::uint64_t, Index> by_normals_;
  std::vector<GlbAccessor> read_only_;
};

Result<std::unique_ptr<Document>> decode_glb(std::string_view bytes, const Limits& limits,
                                             const RunControl& run) {
  auto file = GlbFile::read(bytes, run);
  if (!file) return file.error();
  return GlbReader(std::move(*file), limits, run).read();
}

}  // namespace burnish
