// The distances behind a heat map.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/run/run_control.h"
#include "server/service/loaded_mesh.h"

namespace burnish::cli {

/// Of each vertex of the mesh's file to the nearest point of the reference, in the file's unit; 0 for
/// vertices in no triangle. The largest is the report's maxDistance. Errors: Cancelled, DeadlineExceeded,
/// OutOfMemory.
Result<std::vector<double>> file_vertex_distances(const LoadedMesh& mesh, const LoadedMesh& reference,
                                                  const RunControl& run);

/// A round number that all but one of a hundred values do not exceed: the farthest few would leave the others
/// pale. 1 when they are 0.
double end_of_heat(std::vector<double> values);

/// What the colours of a heat map stand for: the palest is 0.
struct HeatRange {
  double most = 0;     ///< the darkest colour, in the file's unit
  double largest = 0;  ///< the largest distance, which may lie beyond
};

/// Writes the mesh with every vertex in the colour (client/render/color_map.h) of its distance to the
/// reference; those beyond `most` are as dark as `most`, which is end_of_heat() when unset. The file is PLY
/// unless its name promises another format that has colours. Errors: those of load_mesh(), encode_as() and
/// write_file(); BadOption for a format without colours.
Result<HeatRange> write_heatmap(std::string_view reference, std::string_view mesh, std::optional<double> most,
                                const std::string& file, const RunControl& run);

}  // namespace burnish::cli
