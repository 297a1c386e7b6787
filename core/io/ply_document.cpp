#include "core/io/ply_document.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/io/normal_rows.h"
#include "core/io/pins.h"
#include "core/io/ply_source.h"

namespace burnish {
namespace {

using Name = std::string_view;
constexpr std::array<Name, 3> kNormal{"nx", "ny", "nz"};
constexpr std::array<std::array<Name, 3>, 3> kColors{
    {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}, {"r", "g", "b"}}};
constexpr std::array<std::array<Name, 2>, 4> kTextures{
    {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};

/// The value that stands for 1 in a colour of this type.
double full_intensity(PlyType type) {
  switch (type) {
    case PlyType::Float32:
    case PlyType::Float64:
      return 1;
    default: {
      const std::uint64_t bits = 8 * size_of(type);
      const bool is_signed = type == PlyType::Int8 || type == PlyType::Int16 || type == PlyType::Int32;
      return std::ldexp(1.0, static_cast<int>(is_signed ? bits - 1 : bits)) - 1;
    }
  }
}

bool has_all(const PlyElement& element, std::span<const Name> names) {
  return std::ranges::all_of(names, [&](Name name) {
    const PlyProperty* const property = element.find(name);
    return property != nullptr && !property->is_list();
  });
}

/// The first set of names of which the element has all; nothing: it has none.
template <class Sets>
std::span<const Name> first_set(const PlyElement& element, const Sets& sets) {
  for (const auto& names : sets) {
    if (has_all(element, names)) return names;
  }
  return {};
}

float finite_float(double value) {
  const auto narrow = static_cast<float>(value);
  return std::isfinite(narrow) ? narrow : 0.0f;
}

}  // namespace

std::string PlyDocument::place(std::uint64_t offset) const {
  if (header_.encoding == PlyEncoding::Text) return line_place(bytes_, offset);
  return " (byte " + std::to_string(offset) + ')';
}

std::string PlyDocument::vertex_place(Index vertex) const {
  return "vertex " + std::to_string(vertex) + place(vertex_row(vertex));
}

std::string PlyDocument::triangle_place(Index triangle) const {
  if (triangle >= face_triangles_)
    return "triangle " + std::to_string(triangle - face_triangles_) + " of the strips";
  const Index face = face_of_triangle_.empty() ? triangle : face_of_triangle_[triangle];
  // Only messages ask, so the faces are gone through again instead of remembered.
  const std::uint64_t offset =
      with_ply_source(bytes_, begins_[face_element_], header_.encoding, [&](auto& source) {
        std::int64_t count = 0;
        for (Index row = 0; row < face; ++row) {
          read_ply_row(
              source, header_.elements[face_element_], count,
              [&](const PlyProperty& property, std::uint64_t n) { return source.skip(property.type, n); });
        }
        return source.offset();
      });
  return "face " + std::to_string(face) + place(offset);
}

Result<PlyDocument::Columns> PlyDocument::read_columns(Names names, const RunControl& run) const {
  const PlyElement& element = vertices();
  std::vector<const PlyProperty*> wanted;
  for (const Name name : names) wanted.push_back(element.find(name));
  Columns columns(names.size(), std::vector<float>(element.count));
  const bool done = with_ply_source(bytes_, begins_[vertex_element_], header_.encoding, [&](auto& source) {
    return for_each(element.count, run.on_one_thread(), [&](std::size_t row) {
      std::int64_t count = 0;
      read_ply_row(source, element, count, [&](const PlyProperty& property, std::uint64_t n) {
        const auto column = std::ranges::find(wanted, &property);
        double value = 0;
        if (column == wanted.end() || !source.real(property.type, value))
          return source.skip(property.type, n);
        columns[static_cast<std::size_t>(column - wanted.begin())][row] = finite_float(value);
        return true;
      });
    });
  });
  if (!done) return run.stop_error();
  return columns;
}

Result<std::vector<Index>> PlyDocument::attribute_vertices(std::string_view name,
                                                           const RunControl& run) const {
  const PlyProperty* const property = vertices().find(name);
  if (property == nullptr || property->is_list()) {
    KnownNames known;
    for (const PlyProperty& each : vertices().properties) {
      if (!each.is_list()) known.add(each.name);
    }
    return known.missing("attribute", name);
  }
  const auto columns = read_columns({&name, 1}, run);
  if (!columns) return columns.error();
  std::vector<Index> chosen;
  for (Index v = 0; v < columns->front().size(); ++v) {
    if (columns->front()[v] != 0) chosen.push_back(v);
  }
  return chosen;
}

bool PlyDocument::has_normals() const {
  return has_all(vertices(), kNormal) &&
         std::ranges::all_of(kNormal, [&](Name name) { return is_real(vertices().find(name)->type); });
}

Result<NormalRows> PlyDocument::recompute_normals(const MovedPositions& moved, const RunControl& run) const {
  const auto columns = read_columns(kNormal, run);
  if (!columns) return columns.error();
  auto normals = group_normals(
      positions_.size(), moved, run, [](std::size_t v) { return static_cast<Index>(v); },
      [&](std::size_t v) {
        return Vec3f{(*columns)[0][v], (*columns)[1][v], (*columns)[2][v]};
      });
  if (!normals) return normals.error();
  if (auto ok = normals->recompute(moved, triangles_, triangles_, run); !ok) return ok.error();
  return normals;
}

/// What MeshLab keeps with faces: u and v of each corner, in a list. Equal pairs become one row.
Result<std::optional<MeshAttribute>> PlyDocument::face_textures(const RunControl& run) const {
  if (face_element_ == header_.elements.size()) return std::optional<MeshAttribute>();
  const PlyElement& element = header_.elements[face_element_];
  const PlyProperty* const indices = ply_vertex_indices(element);
  const PlyProperty* const pairs = element.find("texcoord");
  if (pairs == nullptr || !pairs->is_list()) return std::optional<MeshAttribute>();
  MeshAttribute textures{2, {}, {}};
  std::unordered_map<std::uint64_t, Index> rows;
  const auto row_of = [&](float u, float v) {
    const std::uint64_t bits =
        std::uint64_t{std::bit_cast<std::uint32_t>(u)} << 32 | std::bit_cast<std::uint32_t>(v);
    const auto [row, is_new] = rows.try_emplace(bits, static_cast<Index>(rows.size()));
    if (is_new) textures.values.insert(textures.values.end(), {u, v});
    return row->second;
  };
  std::vector<float> values;
  const bool done = with_ply_source(bytes_, begins_[face_element_], header_.encoding, [&](auto& source) {
    return for_each(element.count, run.on_one_thread(), [&](std::size_t) {
      std::int64_t count = 0;
      std::uint64_t corners = 0;
      values.clear();
      read_ply_row(source, element, count, [&](const PlyProperty& property, std::uint64_t n) {
        if (&property == indices) corners = n;
        if (&property != pairs) return source.skip(property.type, n);
        for (std::uint64_t i = 0; i < n; ++i) {
          double value = 0;
          if (!source.real(property.type, value) && !source.skip(property.type, 1)) return false;
          values.push_back(finite_float(value));
        }
        return true;
      });
      const auto corner = [&](std::uint64_t c) {
        return 2 * c + 1 < values.size() ? row_of(values[2 * c], values[2 * c + 1]) : kNone;
      };
      for (std::uint64_t c = 2; c < corners; ++c)
        textures.corners.push_back({corner(0), corner(c - 1), corner(c)});
    });
  });
  if (!done) return run.stop_error();
  textures.corners.resize(triangles_.size(), {kNone, kNone, kNone});  // strips have none
  if (rows.empty()) return std::optional<MeshAttribute>();
  return std::optional(std::move(textures));
}

Result<SharedAttributes> PlyDocument::shared_attributes(const MovedPositions& moved,
                                                        const RunControl& run) const {
  SharedAttributes shared;
  std::vector<Name> used{"x", "y", "z"};
  if (has_normals()) {
    auto normals = recompute_normals(moved, run);
    if (!normals) return normals.error();
    MeshAttribute attribute{3, {}, triangles_};
    for (Triangle& corners : attribute.corners) {
      for (Index& corner : corners) corner = normals->row_of_element[corner];
    }
    for (const Vec3f& n : normals->rows) attribute.values.insert(attribute.values.end(), {n.x, n.y, n.z});
    shared.normals = std::move(attribute);
    used.insert(used.end(), kNormal.begin(), kNormal.end());
  }
  if (const Names names = first_set(vertices(), kTextures); !names.empty()) {
    const auto columns = read_columns(names, run);
    if (!columns) return columns.error();
    MeshAttribute attribute{2, {}, triangles_};
    for (std::size_t v = 0; v < positions_.size(); ++v)
      attribute.values.insert(attribute.values.end(), {(*columns)[0][v], (*columns)[1][v]});
    shared.texture_coordinates = std::move(attribute);
    used.insert(used.end(), names.begin(), names.end());
  }
  bool face_pairs = false;
  if (!shared.texture_coordinates) {
    auto textures = face_textures(run);
    if (!textures) return textures.error();
    shared.texture_coordinates = std::move(*textures);
    face_pairs = shared.texture_coordinates.has_value();
  }
  if (const Names names = first_set(vertices(), kColors); !names.empty()) {
    const auto columns = read_columns(names, run);
    if (!columns) return columns.error();
    std::array<double, 3> full{};
    for (std::size_t c = 0; c < 3; ++c) full[c] = full_intensity(vertices().find(names[c])->type);
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = (*columns)[c][v] / full[c];
        shared.colors.push_back(static_cast<float>(std::clamp(value, 0.0, 1.0)));
      }
    }
    used.insert(used.end(), names.begin(), names.end());
  }
  list_dropped(std::move(used), face_pairs, shared);
  return shared;
}

void PlyDocument::list_dropped(std::vector<Name> used, bool textures, SharedAttributes& shared) const {
  for (std::size_t e = 0; e < header_.elements.size(); ++e) {
    const PlyElement& element = header_.elements[e];
    const bool strips = element.name == "tristrips";
    if (e != vertex_element_ && e != face_element_ && !strips) {
      shared.dropped.push_back("the element " + quote(element.name));
      continue;
    }
    for (const PlyProperty& property : element.properties) {
      const bool kept = e == vertex_element_ ? std::ranges::find(used, property.name) != used.end()
                                             : &property == ply_vertex_indices(element) ||
                                                   (textures && property.name == "texcoord");
      if (!kept)
        shared.dropped.push_back("the property " + quote(property.name) + " of " + quote(element.name));
    }
    if (strips) shared.dropped.emplace_back("strips (split into triangles)");
  }
  if (!face_of_triangle_.empty()) shared.dropped.emplace_back("polygons (split into triangles)");
  if (header_.has_comments) shared.dropped.emplace_back("comments");
}

}  // namespace burnish
