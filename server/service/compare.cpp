#include <new>
#include <string>

#include "core/measure/error.h"
#include "server/service/loaded_mesh.h"
#include "server/service/measures.h"
#include "server/service/smooth_service.h"

namespace burnish {
namespace {

Result<v1::CompareResponse> compare_meshes(const CompareJob& job, const Limits& limits,
                                           const RunControl& run) {
  Stopwatch total;
  v1::CompareResponse response;
  response.set_version(std::string(version()));
  response.set_request_id(job.request_id);
  v1::StageTimings& timings = *response.mutable_timings();

  const auto reference = load_mesh(job.reference, job.reference_format, "reference: ", limits, run, timings);
  if (!reference) return reference.error();
  reference->summarise(*response.mutable_reference());
  const auto mesh = load_mesh(job.mesh, job.format, "mesh: ", limits, run, timings);
  if (!mesh) return mesh.error();
  mesh->summarise(*response.mutable_mesh());
  add_warnings(mesh->warnings(), *response.mutable_warnings());

  Stopwatch watch;
  const bool corresponding = same_connectivity(*mesh->document, *reference->document);
  const auto errors = measure_errors(mesh->surface, mesh->surface.mesh.positions, reference->surface,
                                     reference->surface.mesh.positions, corresponding, run);
  if (!errors) return errors.error();
  fill(*errors, "reference", *response.mutable_errors());
  if (!corresponding) add_warnings({connectivity_differs()}, *response.mutable_warnings());
  timings.set_measure_ms(watch.lap());
  timings.set_queue_ms(job.queue_ms);
  timings.set_total_ms(job.queue_ms + total.lap());
  return response;
}

}  // namespace

Result<> SmoothService::check(const CompareJob& job) const {
  if (job.reference.empty()) return Error{Cause::EmptyMesh, "the reference has no bytes"};
  if (job.mesh.empty()) return Error{Cause::EmptyMesh, "the mesh has no bytes"};
  if (auto fits = check_size(job.reference.size(), "the reference"); !fits) return fits;
  return check_size(job.mesh.size(), "the mesh");
}

Result<v1::CompareResponse> SmoothService::compare(const CompareJob& job, const RunControl& run) const {
  try {
    if (auto fine = check(job); !fine) return fine.error();
    return compare_meshes(job, limits_.mesh, run);
  } catch (const std::bad_alloc&) {
    return Error{Cause::OutOfMemory, "the meshes need more memory than there is"};
  } catch (const std::exception& failure) {
    return Error{Cause::Internal, std::string("unexpected failure: ") + failure.what()};
  }
}

}  // namespace burnish
