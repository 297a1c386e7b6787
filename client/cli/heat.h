// The distances behind a heat map.
#pragma once

#include <string>
#include <vector>

#include "core/run/run_control.h"
#include "server/service/loaded_mesh.h"

namespace burnish::cli {

/// Of each vertex of the mesh's file to the nearest point of the reference, in the file's unit; 0 for
/// vertices in no triangle. The largest is the report's maxDistance. Errors: Cancelled, DeadlineExceeded,
/// OutOfMemory.
Result<std::vector<double>> file_vertex_distances(const LoadedMesh& mesh, const LoadedMesh& reference,
                                                  const RunControl& run);

}  // namespace burnish::cli
