#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/heat.h"
#include "client/cli/mesh_files.h"
#include "client/cli/place.h"
#include "client/cli/report_table.h"
#include "client/smoothing_client.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

struct CompareArguments {
  std::string reference, mesh, heatmap;
  Place place;
  std::optional<double> heat_most;
  bool json = false;
};

/// The comparison, with one key more when there is a heat map.
void print_json(std::ostream& out, const v1::CompareResponse& comparison, const std::string& heatmap,
                const std::optional<HeatRange>& range) {
  if (!range) {
    out << to_json(comparison, false) << "\n";
    return;
  }
  auto json = nlohmann::ordered_json::parse(to_json(comparison, true));
  json["heatmap"] = {{"file", heatmap}, {"most", range->most}, {"largest", range->largest}};
  out << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

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
  const auto call = call_options(place, console);
  if (!call) return call.error();
  auto reply = client->compare(request, *call);
  if (!reply) return error_from(reply.error(), place);
  return std::move(*reply);
}

Result<> compare(const CompareArguments& arguments, const Console& console) {
  if (auto writable = arguments.heatmap.empty() ? Result<>() : check_writable(arguments.heatmap); !writable)
    return writable;
  Result<std::string> reference = read_input(arguments.reference, console);
  if (!reference) return reference.error();
  Result<std::string> mesh = read_input(arguments.mesh, console);
  if (!mesh) return mesh.error();
  const Place& place = arguments.place;
  std::optional<HeatRange> range;
  if (!arguments.heatmap.empty()) {
    const auto made =
        write_heatmap(*reference, *mesh, arguments.heat_most, arguments.heatmap, run_control(place, console));
    if (!made) return made.error();
    range = *made;
  }
  const Result<v1::CompareResponse> comparison =
      place.server.empty() ? compare_here(*reference, *mesh, place, console)
                           : compare_there(std::move(*reference), std::move(*mesh), place, console);
  if (!comparison) return comparison.error();
  if (arguments.json) {
    print_json(console.out, *comparison, arguments.heatmap, range);
    return {};
  }
  print_comparison(console.out, *comparison);
  if (range) print_heatmap(console.out, arguments.heatmap, range->most, range->largest);
  return {};
}

}  // namespace

void add_compare_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand("compare", "Measure a mesh against a reference, without smoothing");
  command->add_option("REFERENCE", arguments->reference, "The mesh that is right")
      ->type_name("FILE")
      ->required();
  command->add_option("MESH", arguments->mesh, "The mesh to measure; its connectivity may differ")
      ->type_name("FILE")
      ->required();
  CLI::Option* const heatmap = command
                                   ->add_option("--heatmap", arguments->heatmap,
                                                "Write MESH with every vertex coloured by its distance to "
                                                "REFERENCE, as PLY unless the name says otherwise")
                                   ->type_name("FILE");
  command
      ->add_option("--heat-most", arguments->heat_most,
                   "Distance of the darkest colour; default: what 99% do not exceed, rounded up")
      ->check(CLI::Range(1e-30, 1e60))
      ->needs(heatmap);
  add_place(command, arguments->place);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return compare(*arguments, console); };
  });
}

}  // namespace burnish::cli
