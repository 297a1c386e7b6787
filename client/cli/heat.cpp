#include "client/cli/heat.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "client/render/color_map.h"
#include "core/io/codec.h"
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

double end_of_heat(std::vector<double> values) {
  if (values.empty()) return 1;
  const auto rank = values.begin() + static_cast<std::ptrdiff_t>(values.size() - 1 - values.size() / 100);
  std::nth_element(values.begin(), rank, values.end());
  return *rank > 0 ? render::round_up(*rank) : 1;
}

Result<HeatRange> write_heatmap(std::string_view reference, std::string_view mesh, std::optional<double> most,
                                const std::string& file, const RunControl& run) {
  const Format format = format_of_name(file).value_or(Format::Ply);
  if (!traits_of(format).carries_colors) {
    return Error{Cause::BadOption,
                 std::string(traits_of(format).title) + " has no colours; --heatmap wants another ending"};
  }
  v1::StageTimings timings;
  const auto truth = load_mesh(reference, std::nullopt, "reference: ", no_limits(), run, timings);
  if (!truth) return truth.error();
  const auto loaded = load_mesh(mesh, std::nullopt, "", no_limits(), run, timings);
  if (!loaded) return loaded.error();
  const auto distances = file_vertex_distances(*loaded, *truth, run);
  if (!distances) return distances.error();
  const HeatRange range{most.value_or(end_of_heat(*distances)),
                        *std::max_element(distances->begin(), distances->end())};
  SharedAttributes attributes;
  for (const double distance : *distances) {
    for (const std::uint8_t value : render::heat_color(distance / range.most)) {
      attributes.colors.push_back(static_cast<float>(value) / 255);
    }
  }
  const Surface& surface = loaded->surface;
  const MovedPositions still{loaded->document->positions(), surface.weld, surface.mesh.positions,
                             surface.mesh.positions, surface.mesh.frame};
  const auto encoded =
      encode_as(format, still, loaded->document->triangles(), std::move(attributes), {}, run);
  if (!encoded) return encoded.error();
  if (auto written = write_file(file, encoded->bytes); !written) return written.error();
  return range;
}

}  // namespace burnish::cli
