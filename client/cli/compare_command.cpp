#include <memory>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "client/cli/place.h"
#include "client/cli/report_table.h"
#include "client/smoothing_client.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

struct CompareArguments {
  std::string reference, mesh;
  Place place;
  bool json = false;
};

Result<v1::CompareResponse> compare_here(const std::string& reference, const std::string& mesh,
                                         const Place& place, const Console& console) {
  const CompareJob job{.reference = reference, .mesh = mesh, .request_id = "local"};
  return SmoothService({.mesh = no_limits()}).compare(job, run_control(place, console));
}

Result<v1::CompareResponse> compare_there(std::string reference, std::string mesh, const Place& place,
                                          const Console& console) {
  v1::CompareRequest request;
  request.set_reference(std::move(reference));
  request.set_mesh(std::move(mesh));
  const auto client = connect(place);
  if (!client) return client.error();
  auto reply = client->compare(request, call_options(place, console));
  if (!reply) return error_from(reply.error(), place);
  return std::move(*reply);
}

Result<> compare(const CompareArguments& arguments, const Console& console) {
  Result<std::string> reference = read_file(arguments.reference);
  if (!reference) return reference.error();
  Result<std::string> mesh = read_file(arguments.mesh);
  if (!mesh) return mesh.error();
  const Place& place = arguments.place;
  const Result<v1::CompareResponse> comparison =
      place.server.empty() ? compare_here(*reference, *mesh, place, console)
                           : compare_there(std::move(*reference), std::move(*mesh), place, console);
  if (!comparison) return comparison.error();
  if (arguments.json) {
    console.out << to_json(*comparison, false) << "\n";
  } else {
    print_comparison(console.out, *comparison);
  }
  return {};
}

}  // namespace

void add_compare_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand("compare", "Measure a mesh against a reference, without smoothing");
  command->add_option("REFERENCE", arguments->reference, "The mesh that is right")->required();
  command->add_option("MESH", arguments->mesh, "The mesh to measure; its connectivity may differ")
      ->required();
  add_place(command, arguments->place);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return compare(*arguments, console); };
  });
}

}  // namespace burnish::cli
