// Which elements of a PLY are the mesh.
#include "core/io/pins.h"
#include "core/io/ply_header.h"

namespace burnish {
namespace {

constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};

std::string declared(const PlyElement& element) { return " (line " + std::to_string(element.line) + ')'; }

Result<> find_axes(const PlyElement& vertices, std::array<const PlyProperty*, 3>& axes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    axes[axis] = vertices.find(kAxes[axis]);
    if (axes[axis] == nullptr || axes[axis]->is_list()) {
      return Error{Cause::MalformedMesh, "the element \"vertex\" has no property \"" +
                                             std::string(kAxes[axis]) + '"' + declared(vertices)};
    }
    if (!is_real(axes[axis]->type)) {
      return Error{Cause::UnsupportedFormat, "the property \"" + std::string(kAxes[axis]) + "\" is " +
                                                 std::string(name_of(axes[axis]->type)) +
                                                 "; positions must be float or double" + declared(vertices)};
    }
  }
  return {};
}

Result<> check_indices(const PlyElement& faces) {
  const PlyProperty* const indices = ply_vertex_indices(faces);
  if (indices == nullptr) {
    return Error{Cause::MalformedMesh,
                 "the element " + quote(faces.name) + " has no list \"vertex_indices\"" + declared(faces)};
  }
  if (!is_real(indices->type)) return {};
  return Error{Cause::UnsupportedFormat, "the list " + quote(indices->name) + " is of " +
                                             std::string(name_of(indices->type)) +
                                             "; indices must be whole numbers" + declared(faces)};
}

}  // namespace

Result<PlyLayout> find_ply_layout(const PlyHeader& header, const Limits& limits) {
  const std::size_t none = header.elements.size();
  PlyLayout layout{header.find("vertex"), header.find("face"), {}};
  const std::size_t strips = header.find("tristrips");
  if (layout.vertices == none || header.elements[layout.vertices].count == 0)
    return Error{Cause::EmptyMesh, "the PLY file has no vertex"};
  const PlyElement& vertices = header.elements[layout.vertices];
  if (layout.faces == none && strips == none) {
    return Error{Cause::NotATriangleMesh,
                 "the PLY file holds points only, no element \"face\" or \"tristrips\""};
  }
  if (vertices.count > limits.max_vertices)
    return ply_too_large(vertices, "vertices", limits.max_vertices, "max-vertices");
  if (auto ok = find_axes(vertices, layout.axes); !ok) return ok.error();
  for (const std::size_t e : {layout.faces, strips}) {
    if (e == none) continue;
    const PlyElement& faces = header.elements[e];
    if (e == layout.faces && faces.count > limits.max_triangles)
      return ply_too_large(faces, "triangles", limits.max_triangles, "max-triangles");
    if (auto ok = check_indices(faces); !ok) return ok.error();
  }
  return layout;
}

const PlyProperty* ply_vertex_indices(const PlyElement& element) {
  for (const std::string_view name : {"vertex_indices", "vertex_index"}) {
    const PlyProperty* const property = element.find(name);
    if (property != nullptr && property->is_list()) return property;
  }
  return nullptr;
}

Error ply_too_large(const PlyElement& element, const std::string& what, std::uint64_t limit,
                    const std::string& name) {
  return {Cause::TooLarge, "the mesh has more than " + std::to_string(limit) + ' ' + what + " (" + name +
                               ')' + declared(element)};
}

}  // namespace burnish
