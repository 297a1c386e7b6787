#include "core/io/draco_document.h"

#include <string>

namespace burnish {
namespace {

using Attribute = draco::GeometryAttribute;

Vec3f normal_at(const draco::PointAttribute& attribute, Index point) {
  Vec3f normal;
  std::array<float, 3> value{};
  if (attribute.ConvertValue<float>(value_of(attribute, point), 3, value.data())) {
    normal = {value[0], value[1], value[2]};
  }
  return normal;
}

/// The value that stands for 1 in a colour of this type.
double full_intensity(draco::DataType type) {
  switch (type) {
    case draco::DT_UINT8:
      return 255;
    case draco::DT_INT8:
      return 127;
    case draco::DT_UINT16:
      return 65535;
    case draco::DT_INT16:
      return 32767;
    case draco::DT_UINT32:
      return 4294967295.0;
    case draco::DT_INT32:
      return 2147483647;
    default:
      return 1;
  }
}

/// Red, green and blue per point, in [0, 1]; what is not a number becomes 0.
bool read_colors(const draco::PointAttribute& attribute, std::vector<float>& colors, const RunControl& run) {
  const double full = full_intensity(attribute.data_type());
  // Plain numbers: the library's own scaling of normalised integers would be applied on top of ours.
  draco::PointAttribute plain;
  plain.CopyFrom(attribute);
  plain.set_normalized(false);
  return for_each_index(colors.size() / 3, run, [&](Index p) {
    std::array<double, 3> rgb{};
    if (!plain.ConvertValue<double>(value_of(plain, p), 3, rgb.data())) return;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = rgb[c] / full;
      colors[3 * std::size_t{p} + c] = value > 0 ? static_cast<float>(std::min(value, 1.0)) : 0.0f;
    }
  });
}

Result<MeshAttribute> read_texture_coordinates(const draco::PointAttribute& attribute,
                                               std::span<const Triangle> triangles, const RunControl& run) {
  MeshAttribute result{2, std::vector<float>(2 * attribute.size()), {}};
  result.corners.reserve(triangles.size());
  const bool done = for_each_index(attribute.size(), run,
                                   [&](Index row) {
                                     attribute.ConvertValue<float>(draco::AttributeValueIndex(row), 2,
                                                                   &result.values[2 * std::size_t{row}]);
                                   }) &&
                    for_each_index(triangles.size(), run, [&](Index t) {
                      Triangle rows;
                      for (std::size_t c = 0; c < 3; ++c)
                        rows[c] = value_of(attribute, triangles[t][c]).value();
                      result.corners.push_back(rows);
                    });
  if (!done) return run.stop_error();
  return result;
}

Result<MeshAttribute> read_normals(const draco::PointAttribute& attribute, const MovedPositions& moved,
                                   std::span<const Triangle> triangles, const RunControl& run) {
  auto normals = recompute_normals(attribute, moved, triangles, run);
  if (!normals) return normals.error();
  MeshAttribute result{3, {}, {}};
  result.values.reserve(3 * normals->rows.size());
  for (const Vec3f& n : normals->rows) result.values.insert(result.values.end(), {n.x, n.y, n.z});
  result.corners.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    result.corners.push_back(
        {normals->row_of_element[t[0]], normals->row_of_element[t[1]], normals->row_of_element[t[2]]});
  }
  return result;
}

Result<> write_normals(draco::PointAttribute& attribute, const MovedPositions& moved,
                       std::span<const Triangle> triangles, const RunControl& run) {
  const auto normals = recompute_normals(attribute, moved, triangles, run);
  if (!normals) return normals.error();
  const bool done = for_each_index(normals->row_of_element.size(), run, [&](Index p) {
    const Index row = normals->row_of_element[p];
    if (normals->changed[row] != 0) attribute.SetAttributeValue(value_of(attribute, p), &normals->rows[row]);
  });
  return done ? Result<>{} : run.stop_error();
}

std::string describe(const draco::PointAttribute& attribute) {
  const auto name = [&]() -> std::string {
    switch (attribute.attribute_type()) {
      case Attribute::NORMAL:
        return "normals";
      case Attribute::COLOR:
        return "colours";
      case Attribute::TEX_COORD:
        return "texture coordinates";
      case Attribute::GENERIC:
        return "generic attribute";
      default:
        return "attribute";
    }
  }();
  const int components = attribute.num_components();
  return name + ' ' + std::to_string(attribute.unique_id()) + " (" + std::to_string(components) +
         (components == 1 ? " component)" : " components)");
}

}  // namespace

DracoDocument::DracoDocument(std::unique_ptr<const draco::Mesh> mesh, DracoMethod method,
                             std::vector<DracoCoding> codings, std::vector<Vec3d> positions,
                             std::vector<Triangle> triangles)
    : Document(Format::Draco), mesh_(std::move(mesh)), method_(method), codings_(std::move(codings)) {
  positions_ = std::move(positions);
  triangles_ = std::move(triangles);
}

Result<NormalRows> recompute_normals(const draco::PointAttribute& attribute, const MovedPositions& moved,
                                     std::span<const Triangle> triangles, const RunControl& run) {
  auto normals = group_normals(
      moved.weld.size(), moved, run, [](std::size_t point) { return static_cast<Index>(point); },
      [&](std::size_t point) { return normal_at(attribute, static_cast<Index>(point)); });
  if (!normals) return normals.error();
  if (auto ok = normals->recompute(moved, triangles, triangles, run); !ok) return ok.error();
  return normals;
}

Result<Encoded> DracoDocument::encode_same(const MovedPositions& moved, const OutputOptions& options,
                                           const RunControl& run) const {
  return without_exceptions(Cause::CannotEncode, [&]() -> Result<Encoded> {
    if (auto ok = run.check(); !ok) return ok.error();
    draco::Mesh mesh;
    mesh.Copy(*mesh_);
    std::vector<Warning> warnings;
    for (int id = 0; id < mesh.num_attributes(); ++id) {
      draco::PointAttribute& attribute = *mesh.attribute(id);
      if (attribute.attribute_type() != draco::GeometryAttribute::NORMAL) continue;
      if (attribute.data_type() != draco::DT_FLOAT32 || attribute.num_components() != 3) {
        warnings.push_back({"normals_not_recomputed",
                            "attribute " + std::to_string(id) +
                                " holds normals in a form that is not recomputed; "
                                "they are those of the input",
                            1});
      } else if (auto ok = write_normals(attribute, moved, triangles_, run); !ok) {
        return ok.error();
      }
    }
    auto encoded =
        write_draco(mesh, moved, codings_, options.draco.method.value_or(method_), options.draco, run);
    if (encoded) encoded->warnings.insert(encoded->warnings.begin(), warnings.begin(), warnings.end());
    return encoded;
  });
}

Result<SharedAttributes> DracoDocument::shared_attributes(const MovedPositions& moved,
                                                          const RunControl& run) const {
  SharedAttributes shared;
  for (int id = 0; id < mesh_->num_attributes(); ++id) {
    const draco::PointAttribute& attribute = *mesh_->attribute(id);
    // The library reads bytes of this kind as bool, which only 0 and 1 may be.
    const bool readable = attribute.data_type() != draco::DT_BOOL;
    const Attribute::Type type = readable ? attribute.attribute_type() : Attribute::GENERIC;
    const int components = attribute.num_components();
    if (type == Attribute::POSITION) continue;
    if (type == Attribute::NORMAL && components == 3 && !shared.normals) {
      auto normals = read_normals(attribute, moved, triangles_, run);
      if (!normals) return normals.error();
      shared.normals = *std::move(normals);
    } else if (type == Attribute::TEX_COORD && components == 2 && !shared.texture_coordinates) {
      auto coordinates = read_texture_coordinates(attribute, triangles_, run);
      if (!coordinates) return coordinates.error();
      shared.texture_coordinates = *std::move(coordinates);
    } else if (type == Attribute::COLOR && components >= 3 && shared.colors.empty()) {
      shared.colors.resize(3 * positions_.size());
      if (!read_colors(attribute, shared.colors, run)) return run.stop_error();
      if (components > 3) shared.dropped.push_back("the opacity of " + describe(attribute));
    } else {
      shared.dropped.push_back(describe(attribute));
    }
  }
  if (mesh_->GetMetadata() != nullptr) shared.dropped.push_back("metadata");
  return shared;
}

}  // namespace burnish
