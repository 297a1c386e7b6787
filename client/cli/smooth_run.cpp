#include "client/cli/smooth_run.h"

#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "client/cli/progress_bar.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

/// The files that go in.
struct Inputs {
  std::string mesh, reference;
};

Result<Inputs> read_inputs(const std::string& in, const std::string& reference, const Console& console) {
  Inputs inputs;
  Result<std::string> mesh = read_input(in, console);
  if (!mesh) return mesh.error();
  inputs.mesh = std::move(*mesh);
  if (reference.empty()) return inputs;
  Result<std::string> other = read_file(reference);
  if (!other) return other.error();
  if (other->empty()) return Error{Cause::EmptyMesh, "the reference '" + reference + "' is empty"};
  inputs.reference = std::move(*other);
  return inputs;
}

Result<Smoothed> smooth_here(const Place& place, const Inputs& inputs, v1::SmoothOptions options,
                             ProgressBar& bar, const Console& console) {
  SmoothJob job{.mesh = inputs.mesh,
                .reference = inputs.reference,
                .options = std::move(options),
                .request_id = "local"};
  if (console.err_is_terminal) {
    job.progress = [&bar](v1::SmoothStage stage, double fraction) { bar.show(stage, fraction); };
  }
  auto result = SmoothService({.mesh = no_limits()}).smooth(job, run_control(place, console));
  if (!result) return result.error();
  return Smoothed{std::move(result->mesh), std::move(result->report)};
}

Result<Smoothed> smooth_there(const Place& place, Inputs inputs, v1::SmoothOptions options, ProgressBar& bar,
                              const Console& console) {
  v1::SmoothRequest request;
  request.set_mesh(std::move(inputs.mesh));
  request.set_reference(std::move(inputs.reference));
  *request.mutable_options() = std::move(options);
  auto call = call_options(place, console);
  if (!call) return call.error();
  if (console.err_is_terminal) {
    call->progress = [&bar](const v1::SmoothProgress& now) { bar.show(now.stage(), now.fraction()); };
  }
  const auto client = connect(place);
  if (!client) return client.error();
  auto reply = client->smooth(request, *call);
  if (!reply) return error_from(reply.error(), place);
  return Smoothed{std::move(*reply->mutable_mesh()), std::move(*reply->mutable_report())};
}

}  // namespace

Result<Smoothed> smooth_file(const SmoothArguments& arguments, const std::string& in, const std::string& out,
                             const std::string& title, const Console& console) {
  Result<v1::SmoothOptions> options = smooth_options(arguments, out);
  if (!options) return options.error();
  Result<Inputs> inputs = read_inputs(in, arguments.reference, console);
  if (!inputs) return inputs.error();
  ProgressBar bar(console.err, title);
  const Place& place = arguments.place;
  return place.server.empty() ? smooth_here(place, *inputs, std::move(*options), bar, console)
                              : smooth_there(place, std::move(*inputs), std::move(*options), bar, console);
}

}  // namespace burnish::cli
