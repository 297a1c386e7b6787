// Points of a Draco mesh that one of its attributes chooses.
#include <cstring>

#include "core/io/draco_document.h"
#include "core/io/pins.h"

namespace burnish {
namespace {

/// The metadata entry "name"; empty when it has none.
std::string name_of(const draco::Mesh& mesh, int id) {
  std::string name;
  const draco::AttributeMetadata* const metadata = mesh.GetAttributeMetadataByAttributeId(id);
  if (metadata == nullptr || !metadata->GetEntryString("name", &name)) return {};
  return name;
}

std::string number_of(const draco::Mesh& mesh, int id) {
  return std::to_string(mesh.attribute(id)->unique_id());
}

const draco::PointAttribute* find_attribute(const draco::Mesh& mesh, std::string_view wanted) {
  if (wanted.empty()) return nullptr;  // no name, as most have
  for (const auto& text : {name_of, number_of}) {
    for (int id = 0; id < mesh.num_attributes(); ++id) {
      if (text(mesh, id) == wanted) return mesh.attribute(id);
    }
  }
  return nullptr;
}

template <class Float>
bool any_nonzero(const std::uint8_t* bytes, int components) {
  for (int c = 0; c < components; ++c) {
    Float value;
    std::memcpy(&value, bytes + static_cast<std::size_t>(c) * sizeof value, sizeof value);
    if (value != 0) return true;
  }
  return false;
}

/// The library's own conversions refuse some types; bytes tell zero from all else, but for the two zeros of
/// floats.
bool is_nonzero(const draco::PointAttribute& attribute, draco::AttributeValueIndex value) {
  const std::uint8_t* const bytes = attribute.GetAddress(value);
  const int components = attribute.num_components();
  if (attribute.data_type() == draco::DT_FLOAT32) return any_nonzero<float>(bytes, components);
  if (attribute.data_type() == draco::DT_FLOAT64) return any_nonzero<double>(bytes, components);
  return any_nonzero<std::uint8_t>(bytes, components * draco::DataTypeLength(attribute.data_type()));
}

}  // namespace

Result<std::vector<Index>> DracoDocument::attribute_vertices(std::string_view name,
                                                             const RunControl& run) const {
  const draco::PointAttribute* const attribute = find_attribute(*mesh_, name);
  if (attribute == nullptr) {
    KnownNames known;
    for (int id = 0; id < mesh_->num_attributes(); ++id) {
      const std::string own = name_of(*mesh_, id);
      known.add(own.empty() ? number_of(*mesh_, id) : own);
    }
    return known.missing("attribute", name);
  }
  std::vector<Index> points;
  const bool done = for_each_index(mesh_->num_points(), run, [&](Index point) {
    if (is_nonzero(*attribute, value_of(*attribute, point))) points.push_back(point);
  });
  if (!done) return run.stop_error();
  return points;
}

}  // namespace burnish
