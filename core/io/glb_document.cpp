#include "core/io/glb_document.h"

#include <algorithm>

#include "core/io/pins.h"

namespace burnish {
namespace {

using Kind = JsonValue::Kind;

const std::string* name_of(const JsonValue& json) {
  const JsonValue* const name = json.find("name");
  return name != nullptr && name->is(Kind::String) && !name->text.empty() ? &name->text : nullptr;
}

Vec3f draco_normal(const draco::PointAttribute& attribute, Index point) {
  const auto n = attribute.GetValue<float, 3>(value_of(attribute, point));
  return {n[0], n[1], n[2]};
}

}  // namespace

std::string glb_place(const GlbFile& file, Index mesh, Index primitive) {
  const std::string* const name = name_of(file.json().find("meshes")->items[mesh]);
  return "mesh " + std::to_string(mesh) + (name == nullptr ? "" : ' ' + quote(*name)) + ", primitive " +
         std::to_string(primitive);
}

Vec3d read_row(const GlbFile& file, const GlbAccessor& accessor, std::uint64_t row) {
  const char* at = file.buffer(accessor.buffer).data() + accessor.begin + row * accessor.stride;
  Vec3d value;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(3, accessor.components); ++axis) {
    value[axis] = read_component(at, accessor.component);
    if (accessor.normalized) {
      // The most negative integer stands for -1 as well.
      value[axis] = std::max(value[axis] / full_scale(accessor.component), -1.0);
    }
    at += component_bytes(accessor.component);
  }
  return value;
}

int glb_draco_attribute(const draco::Mesh& mesh, const JsonValue& ids, std::string_view semantic) {
  const JsonValue* const wanted = ids.find(semantic);
  for (int id = 0; id < mesh.num_attributes(); ++id) {
    if (wanted != nullptr && wanted->is(Kind::Number) && wanted->number == mesh.attribute(id)->unique_id()) {
      return id;
    }
  }
  return -1;
}

std::string GlbDocument::place_of(const GlbPrimitive& primitive) const {
  return glb_place(file_, primitive.mesh, primitive.number);
}

std::string GlbDocument::vertex_place(Index vertex) const {
  const auto behind =
      std::ranges::upper_bound(vertices_, vertex, {}, [](const GlbVertices& v) { return v.first; });
  const GlbVertices& vertices = *std::prev(behind);
  return "vertex " + std::to_string(vertex - vertices.first) + " of " +
         place_of(primitives_[vertices.primitive]);
}

std::string GlbDocument::triangle_place(Index triangle) const {
  const auto behind = std::ranges::upper_bound(primitives_, triangle, {},
                                               [](const GlbPrimitive& p) { return p.first_triangle; });
  const GlbPrimitive& primitive = *std::prev(behind);
  return "triangle " + std::to_string(triangle - primitive.first_triangle) + " of " + place_of(primitive);
}

Result<std::vector<Index>> GlbDocument::group_vertices(std::string_view name, const RunControl& run) const {
  // Names of meshes, and of the nodes that place them; a mesh without a name goes by its number.
  KnownNames known;
  std::vector<std::uint8_t> wanted(file_.json().find("meshes")->items.size(), 0);
  bool found = false;
  const auto meet = [&](std::string_view text, Index mesh) {
    known.add(text);
    if (text == name) found = true, wanted[mesh] = 1;
  };
  for (const JsonValue& mesh : file_.json().find("meshes")->items) {
    const auto number = static_cast<Index>(&mesh - file_.json().find("meshes")->items.data());
    const std::string* const own = name_of(mesh);
    meet(own != nullptr ? *own : std::to_string(number), number);
  }
  if (const JsonValue* const nodes = file_.json().find("nodes"); nodes != nullptr) {
    for (const JsonValue& node : nodes->items) {
      const JsonValue* const mesh = node.find("mesh");
      const std::string* const own = name_of(node);
      if (mesh == nullptr || own == nullptr ||
          !(mesh->number >= 0 && mesh->number < static_cast<double>(wanted.size())))
        continue;
      meet(*own, static_cast<Index>(mesh->number));
    }
  }
  if (!found) return known.missing("group", name);
  std::vector<std::uint8_t> inside(positions_.size(), 0);
  for (const GlbPrimitive& primitive : primitives_) {
    if (wanted[primitive.mesh] == 0) continue;
    if (run.stopped()) return run.stop_error();
    const GlbVertices& vertices = vertices_[primitive.vertices];
    std::fill_n(inside.begin() + vertices.first, vertices.count, std::uint8_t{1});
  }
  std::vector<Index> result;
  for (Index v = 0; v < inside.size(); ++v) {
    if (inside[v] != 0) result.push_back(v);
  }
  return result;
}

std::vector<Triangle> GlbDocument::corner_normals() const {
  std::vector<Triangle> corners(triangles_.size(), Triangle{kNone, kNone, kNone});
  for (const GlbPrimitive& primitive : primitives_) {
    if (primitive.normals == kNone) continue;
    const Index shift =
        normals_[primitive.normals].first - vertices_[primitive.vertices].first;  // modulo 2^32
    for (Index t = primitive.first_triangle; t < primitive.first_triangle + primitive.triangles; ++t) {
      for (std::size_t c = 0; c < 3; ++c) corners[t][c] = triangles_[t][c] + shift;
    }
  }
  return corners;
}

Result<NormalRows> GlbDocument::moved_normals(const MovedPositions& moved, const RunControl& run) const {
  if (normals_.empty()) return NormalRows{};
  const std::size_t elements = std::size_t{normals_.back().first} + normals_.back().count;
  std::vector<Index> vertex_of(elements);
  std::vector<Vec3f> values(elements);
  for (const GlbNormals& normals : normals_) {
    const GlbVertices& vertices = vertices_[normals.vertices];
    const bool done = for_each(normals.count, run, [&](std::size_t i) {
      vertex_of[normals.first + i] = static_cast<Index>(vertices.first + i);
      values[normals.first + i] =
          normals.draco_attribute >= 0
              ? draco_normal(*vertices.draco->mesh().attribute(normals.draco_attribute),
                             static_cast<Index>(i))
              : to_float(read_row(file_, normals.accessor, i));
    });
    if (!done) return run.stop_error();
  }
  auto rows = group_normals(
      elements, moved, run, [&](std::size_t e) { return vertex_of[e]; },
      [&](std::size_t e) { return values[e]; });
  if (!rows) return rows.error();
  if (auto ok = rows->recompute(moved, triangles_, corner_normals(), run); !ok) return ok.error();
  return rows;
}

}  // namespace burnish
