#include "server/service/compare.h"

#include <new>

#include "server/service/measures.h"

namespace burnish {
namespace {

Error in(const char* what, Error error) {
  error.message = what + error.message;
  return error;
}

}  // namespace

Result<v1::MeshErrors> compare_meshes(std::string_view reference, std::string_view mesh, const Limits& limits,
                                      const RunControl& run) {
  try {
    const auto reference_document = decode(reference, std::nullopt, limits, run);
    if (!reference_document) return in("reference: ", reference_document.error());
    const auto mesh_document = decode(mesh, std::nullopt, limits, run);
    if (!mesh_document) return in("mesh: ", mesh_document.error());
    const Document &ours = **mesh_document, &theirs = **reference_document;
    const auto surface = prepare_surface(ours.positions(), ours.triangles(), run);
    if (!surface) return surface.error();
    const auto other = prepare_surface(theirs.positions(), theirs.triangles(), run);
    if (!other) return other.error();
    const auto errors = measure_errors(*surface, surface->mesh.positions, *other, other->mesh.positions,
                                       same_connectivity(ours, theirs), run);
    if (!errors) return errors.error();
    v1::MeshErrors filled;
    fill(*errors, "reference", filled);
    return filled;
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "the meshes need more memory than there is"};
  }
}

}  // namespace burnish
