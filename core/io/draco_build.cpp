// Builds a Draco mesh from positions and corner attributes of another format.
#include <array>
#include <cmath>
#include <string>

#include "core/io/draco_document.h"
#include "core/io/seams.h"

namespace burnish {
namespace {

using Attribute = draco::GeometryAttribute;

/// Adds an attribute with `values`, whose row for each point `row_of` tells; kNone gets a row of zeros.
template <class T, class RowOf>
void add_attribute(draco::Mesh& mesh, Attribute::Type type, draco::DataType data_type, int components,
                   std::span<const T> values, std::span<const SeamPoint> points, RowOf row_of) {
  const auto stride = static_cast<std::size_t>(components);
  const auto rows = static_cast<Index>(values.size() / stride);
  Attribute description;
  description.Init(type, nullptr, static_cast<std::uint8_t>(components), data_type,
                   data_type == draco::DT_UINT8, static_cast<std::int64_t>(stride * sizeof(T)), 0);
  const bool gap =
      std::any_of(points.begin(), points.end(), [&](const SeamPoint& p) { return row_of(p) == kNone; });
  const int id = mesh.AddAttribute(description, false, gap ? rows + 1 : rows);
  draco::PointAttribute& attribute = *mesh.attribute(id);
  attribute.buffer()->Write(0, values.data(), values.size_bytes());
  if (gap) {
    const std::vector<T> zeros(stride);
    attribute.SetAttributeValue(draco::AttributeValueIndex(rows), zeros.data());
  }
  for (Index p = 0; p < points.size(); ++p) {
    const Index row = row_of(points[p]);
    attribute.SetPointMapEntry(draco::PointIndex(p), draco::AttributeValueIndex(row == kNone ? rows : row));
  }
}

/// The colours as bytes, when that loses nothing; else empty.
std::vector<std::uint8_t> as_bytes(std::span<const float> colors) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(colors.size());
  for (const float c : colors) {
    const float scaled = c * 255.0f;
    const float whole = std::round(scaled);
    if (!(std::abs(scaled - whole) <= 1e-4f && whole >= 0 && whole <= 255)) return {};
    bytes.push_back(static_cast<std::uint8_t>(whole));
  }
  return bytes;
}

void add_colors(draco::Mesh& mesh, std::span<const float> colors, std::span<const SeamPoint> points) {
  const auto vertex = [](const SeamPoint& p) { return p.vertex; };
  const std::vector<std::uint8_t> bytes = as_bytes(colors);
  if (bytes.empty()) {
    add_attribute<float>(mesh, Attribute::COLOR, draco::DT_FLOAT32, 3, colors, points, vertex);
  } else {
    add_attribute<std::uint8_t>(mesh, Attribute::COLOR, draco::DT_UINT8, 3, bytes, points, vertex);
  }
}

Result<std::vector<float>> float_positions(const MovedPositions& moved, const RunControl& run) {
  std::vector<float> values(3 * moved.original.size());
  const bool done = for_each_index(moved.original.size(), run, [&](Index v) {
    const Vec3f p = to_float(moved.at(v));
    for (std::size_t axis = 0; axis < 3; ++axis) values[3 * std::size_t{v} + axis] = p[axis];
  });
  if (!done) return run.stop_error();
  return values;
}

Result<Encoded> build_and_write(const MovedPositions& moved, std::span<const Triangle> triangles,
                                const SharedAttributes& attributes, const DracoOptions& options,
                                const RunControl& run) {
  const auto positions = float_positions(moved, run);
  if (!positions) return positions.error();
  const auto made = split_at_seams(moved.original.size(), triangles, attributes, run);
  if (!made) return made.error();
  const std::span<const SeamPoint> points = made->points;

  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(points.size()));
  mesh.SetNumFaces(made->triangles.size());
  const bool done = for_each_index(made->triangles.size(), run, [&](Index t) {
    const auto [a, b, c] = made->triangles[t];
    mesh.SetFace(draco::FaceIndex(t), {draco::PointIndex(a), draco::PointIndex(b), draco::PointIndex(c)});
  });
  if (!done) return run.stop_error();

  add_attribute<float>(mesh, Attribute::POSITION, draco::DT_FLOAT32, 3, *positions, points,
                       [](const SeamPoint& p) { return p.vertex; });
  if (attributes.normals) {
    add_attribute<float>(mesh, Attribute::NORMAL, draco::DT_FLOAT32, 3, attributes.normals->values, points,
                         [](const SeamPoint& p) { return p.normal; });
  }
  if (attributes.texture_coordinates) {
    add_attribute<float>(mesh, Attribute::TEX_COORD, draco::DT_FLOAT32, 2,
                         attributes.texture_coordinates->values, points,
                         [](const SeamPoint& p) { return p.texture; });
  }
  if (!attributes.colors.empty()) add_colors(mesh, attributes.colors, points);

  const std::vector<DracoCoding> lossless(static_cast<std::size_t>(mesh.num_attributes()));
  return write_draco(mesh, moved, lossless, options.method.value_or(DracoMethod::Sequential), options, run);
}

}  // namespace

Result<Encoded> encode_as_draco(const MovedPositions& moved, std::span<const Triangle> triangles,
                                const SharedAttributes& attributes, const DracoOptions& options,
                                const RunControl& run) {
  return without_exceptions(Cause::CannotEncode,
                            [&] { return build_and_write(moved, triangles, attributes, options, run); });
}

}  // namespace burnish
