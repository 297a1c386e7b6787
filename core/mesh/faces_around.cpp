#include "core/mesh/faces_around.h"

#include <atomic>

#include "core/run/parallel.h"

namespace burnish {
namespace {

bool has_crowds(const Topology& topology, const RunControl& run) {
  std::atomic<bool> any = false;
  for_each(topology.vertex_faces.rows(), run, [&](std::size_t v) {
    if (topology.vertex_faces[v].size() > FacesAround::kMost) any.store(true, std::memory_order_relaxed);
  });
  return any.load();
}

}  // namespace

FacesAround::FacesAround(const Surface& surface, const RunControl& run)
    : mesh_(surface.mesh), topology_(surface.topology), has_crowds_(has_crowds(topology_, run)) {}

}  // namespace burnish
