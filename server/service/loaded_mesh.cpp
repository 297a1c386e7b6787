#include "server/service/loaded_mesh.h"

#include <chrono>
#include <string>
#include <utility>

namespace burnish {
namespace {

Error in(std::string_view what, Error error) {
  error.message.insert(0, what);
  return error;
}

}  // namespace

double Stopwatch::lap() {
  const auto now = RunControl::Clock::now();
  const std::chrono::duration<double, std::milli> passed = now - start_;
  start_ = now;
  return passed.count();
}

void LoadedMesh::summarise(v1::MeshSummary& summary) const {
  summary.set_vertices(static_cast<std::uint32_t>(document->positions().size()));
  summary.set_triangles(static_cast<std::uint32_t>(document->triangles().size()));
  summary.set_boundary_edges(surface.topology.boundary_edges);
  summary.set_components(surface.topology.components);
}

std::vector<Warning> LoadedMesh::warnings() const {
  return surface_warnings(
      surface, [this](Index v) { return document->vertex_place(v); },
      [this](Index t) { return document->triangle_place(t); });
}

Result<LoadedMesh> load_mesh(std::string_view bytes, std::optional<Format> format, std::string_view what,
                             const Limits& limits, const RunControl& run, v1::StageTimings& timings) {
  Stopwatch watch;
  LoadedMesh mesh;
  auto document = decode(bytes, format, limits, run);
  timings.set_decode_ms(timings.decode_ms() + watch.lap());
  if (!document) return in(what, document.error());
  mesh.document = std::move(*document);
  const Document& file = *mesh.document;
  auto surface = prepare_surface(file.positions(), file.triangles(), run, file.parts());
  timings.set_prepare_ms(timings.prepare_ms() + watch.lap());
  if (!surface) return in(what, surface.error());
  mesh.surface = std::move(*surface);
  return mesh;
}

void add_warnings(const std::vector<Warning>& warnings,
                  google::protobuf::RepeatedPtrField<v1::ReportWarning>& out) {
  for (const Warning& warning : warnings) {
    v1::ReportWarning& added = *out.Add();
    added.set_code(warning.code);
    added.set_message(warning.message);
    added.set_count(warning.count);
  }
}

}  // namespace burnish
