// What of a GLB other formats can carry.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/io/glb_document.h"
#include "core/io/pins.h"

namespace burnish {
namespace {

using Kind = JsonValue::Kind;

double full_scale(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return full_scale(GlbComponent::Int8);
    case draco::DT_UINT8:
      return full_scale(GlbComponent::UInt8);
    case draco::DT_INT16:
      return full_scale(GlbComponent::Int16);
    case draco::DT_UINT16:
      return full_scale(GlbComponent::UInt16);
    default:
      return 1;
  }
}

float finite(float value) { return std::isfinite(value) ? value : 0.0f; }

/// One row of floats for each vertex, of as many components as the file has.
struct VertexValues {
  std::size_t components = 0;
  std::vector<float> values;
};

Result<VertexValues> read_draco(const draco::PointAttribute& attribute, std::size_t points,
                                const RunControl& run) {
  VertexValues result;
  // The library reads bytes of this kind as bool, which only 0 and 1 may be.
  if (attribute.data_type() == draco::DT_BOOL || attribute.num_components() > 4) return result;
  result.components = static_cast<std::size_t>(attribute.num_components());
  result.values.resize(result.components * points);
  const auto scale = static_cast<float>(1 / full_scale(attribute.data_type()));
  // Plain numbers: the library's own scaling of normalised integers would be applied on top of ours.
  draco::PointAttribute plain;
  plain.CopyFrom(attribute);
  plain.set_normalized(false);
  const bool done = for_each_index(points, run, [&](Index point) {
    float* const row = &result.values[result.components * point];
    plain.ConvertValue<float>(value_of(plain, point), static_cast<std::int8_t>(result.components), row);
    for (std::size_t c = 0; c < result.components; ++c) row[c] *= scale;
  });
  if (!done) return run.stop_error();
  return result;
}

Result<VertexValues> read_rows(const GlbFile& file, const GlbAccessor& accessor, const RunControl& run) {
  VertexValues result{accessor.components, std::vector<float>(accessor.components * accessor.count)};
  const double scale = accessor.normalized ? 1 / full_scale(accessor.component) : 1;
  const char* const data = file.buffer(accessor.buffer).data() + accessor.begin;
  const bool done = for_each(accessor.count, run, [&](std::size_t row) {
    for (std::size_t c = 0; c < accessor.components; ++c) {
      const char* const at = data + row * accessor.stride + c * component_bytes(accessor.component);
      const double value = read_component(at, accessor.component) * scale;
      result.values[row * accessor.components + c] = static_cast<float>(value);
    }
  });
  if (!done) return run.stop_error();
  return result;
}

/// An attribute of a primitive, one row a vertex; no components when it is not there, or not to be read.
Result<VertexValues> read_attribute(const GlbDocument& document, const GlbPrimitive& primitive,
                                    std::string_view semantic, const RunControl& run) {
  const JsonValue* const number = primitive.json->find("attributes")->find(semantic);
  const GlbVertices& vertices = document.vertices()[primitive.vertices];
  if (number == nullptr) return VertexValues{};
  if (vertices.draco != nullptr) {
    const JsonValue& extension = *primitive.json->find("extensions")->find("KHR_draco_mesh_compression");
    const draco::Mesh& mesh = vertices.draco->mesh();
    const int id = glb_draco_attribute(mesh, *extension.find("attributes"), semantic);
    if (id >= 0) return read_draco(*mesh.attribute(id), vertices.count, run);
  }
  const auto accessor = document.file().accessor(*number, std::string(semantic));
  if (!accessor || accessor->count != vertices.count) return VertexValues{};
  return read_rows(document.file(), *accessor, run);
}

/// Collects texture coordinates and colours primitive by primitive.
class SharedReader {
 public:
  SharedReader(const GlbDocument& document, const RunControl& run) : document_(document), run_(run) {}

  Result<> read(SharedAttributes& shared) {
    for (const GlbPrimitive& primitive : document_.primitives()) {
      if (auto ok = read_texture_coordinates(primitive); !ok) return ok;
      if (auto ok = read_colors(primitive, shared.colors); !ok) return ok;
      for (const JsonValue& each : primitive.json->find("attributes")->items) {
        constexpr std::string_view kKnown[] = {"POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"};
        if (std::ranges::find(kKnown, each.name) == std::end(kKnown)) dropped_.insert(quote(each.name));
      }
    }
    if (!textures_.values.empty()) {
      textures_.corners.resize(document_.triangles().size(), {kNone, kNone, kNone});
      shared.texture_coordinates = std::move(textures_);
    }
    name_dropped(shared.dropped);
    return {};
  }

 private:
  Result<> read_texture_coordinates(const GlbPrimitive& primitive) {
    const JsonValue* const number = primitive.json->find("attributes")->find("TEXCOORD_0");
    if (number == nullptr) return {};
    const auto [row, is_new] =
        texture_rows_.try_emplace(std::pair(primitive.vertices, number->number), kNone);
    if (is_new) {
      const auto read = read_attribute(document_, primitive, "TEXCOORD_0", run_);
      if (!read) return read.error();
      if (read->components == 2 && has_room_for(read->values.size())) {
        row->second = static_cast<Index>(textures_.values.size() / 2);
        textures_.components = 2;
        for (std::size_t i = 0; i < read->values.size(); i += 2) {
          // glTF counts from the top of the picture, the others from its foot.
          textures_.values.insert(textures_.values.end(),
                                  {finite(read->values[i]), finite(1 - read->values[i + 1])});
        }
      } else {
        dropped_.insert("TEXCOORD_0");
      }
    }
    if (row->second == kNone) return {};
    textures_.corners.resize(document_.triangles().size(), {kNone, kNone, kNone});
    const Index shift = row->second - document_.vertices()[primitive.vertices].first;  // modulo 2^32
    const bool done = for_each(primitive.triangles, run_, [&](std::size_t i) {
      const std::size_t t = primitive.first_triangle + i;
      for (std::size_t c = 0; c < 3; ++c) textures_.corners[t][c] = document_.triangles()[t][c] + shift;
    });
    return done ? Result<>{} : run_.stop_error();
  }

  /// A small file may name the same rows a thousand times.
  bool has_room_for(std::size_t more) const {
    return textures_.values.size() + more <= 2 * 4 * document_.positions().size();
  }

  /// The first primitive that colours a set of vertices counts; others are white, as glTF has it.
  Result<> read_colors(const GlbPrimitive& primitive, std::vector<float>& colors) {
    if (primitive.json->find("attributes")->find("COLOR_0") == nullptr) return {};
    if (!colored_.insert(primitive.vertices).second) return {};
    const auto read = read_attribute(document_, primitive, "COLOR_0", run_);
    if (!read) return read.error();
    if (read->components < 3) {
      dropped_.insert("COLOR_0");
      return {};
    }
    colors.resize(3 * document_.positions().size(), 1);
    const GlbVertices& vertices = document_.vertices()[primitive.vertices];
    for (std::size_t v = 0; v < vertices.count; ++v) {
      const float* const row = &read->values[v * read->components];
      for (std::size_t c = 0; c < 3; ++c) {
        colors[3 * (vertices.first + v) + c] = row[c] > 0 ? std::min(row[c], 1.0f) : 0.0f;
      }
      if (read->components > 3 && row[3] != 1) opacity_ = true;
    }
    return {};
  }

  void name_dropped(std::vector<std::string>& dropped) const {
    const JsonValue& json = document_.file().json();
    constexpr std::pair<std::string_view, const char*> kLists[] = {
        {"materials", "materials"}, {"textures", "textures"}, {"animations", "animations"},
        {"skins", "skins"},         {"cameras", "cameras"},   {"extras", "extras"}};
    for (const auto& [list, name] : kLists) {
      if (json.find(list) != nullptr) dropped.emplace_back(name);
    }
    if (places_meshes(json)) dropped.emplace_back("the nodes that place the meshes");
    const GlbPassedOver& passed = document_.passed_over();
    if (passed.primitives > 0) dropped.emplace_back("primitives that are no triangles");
    if (passed.targets > 0) dropped.emplace_back("morph targets");
    if (opacity_) dropped.emplace_back("the opacity of COLOR_0");
    for (const std::string& name : dropped_) dropped.push_back(name);
  }

  static bool places_meshes(const JsonValue& json) {
    const JsonValue* const nodes = json.find("nodes");
    if (nodes == nullptr) return false;
    return std::ranges::any_of(nodes->items, [](const JsonValue& node) {
      constexpr std::string_view kMoves[] = {"matrix", "translation", "rotation", "scale"};
      return std::ranges::any_of(kMoves, [&](std::string_view name) { return node.find(name) != nullptr; });
    });
  }

  const GlbDocument& document_;
  const RunControl& run_;
  MeshAttribute textures_;
  std::map<std::pair<Index, double>, Index> texture_rows_;
  std::set<Index> colored_;
  std::set<std::string> dropped_;
  bool opacity_ = false;
};

}  // namespace

Result<SharedAttributes> GlbDocument::shared_attributes(const MovedPositions& moved,
                                                        const RunControl& run) const {
  SharedAttributes shared;
  if (!normals_.empty()) {
    const auto rows = moved_normals(moved, run);
    if (!rows) return rows.error();
    MeshAttribute normals{3, {}, corner_normals()};
    normals.values.reserve(3 * rows->rows.size());
    for (const Vec3f& n : rows->rows)
      normals.values.insert(normals.values.end(), {finite(n.x), finite(n.y), finite(n.z)});
    for (Triangle& t : normals.corners) {
      for (Index& corner : t) corner = corner == kNone ? kNone : rows->row_of_element[corner];
    }
    shared.normals = std::move(normals);
  }
  if (auto ok = SharedReader(*this, run).read(shared); !ok) return ok.error();
  return shared;
}

}  // namespace burnish
