#include "client/cli/heat.h"

#include "core/measure/error.h"
#include "server/service/measures.h"

namespace burnish::cli {

Result<std::vector<double>> file_vertex_distances(const LoadedMesh& mesh, const LoadedMesh& reference,
                                                  const RunControl& run) {
  const auto distances = vertex_distances(mesh.surface, mesh.surface.mesh.positions, reference.surface,
                                          reference.surface.mesh.positions,
                                          same_connectivity(*mesh.document, *reference.document), run);
  if (!distances) return distances.error();
  std::vector<double> result;
  result.reserve(mesh.surface.weld.size());
  for (const Index v : mesh.surface.weld) result.push_back((*distances)[v]);
  return result;
}

}  // namespace burnish::cli
