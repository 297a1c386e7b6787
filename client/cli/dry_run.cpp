#include "client/cli/dry_run.h"

#include <nlohmann/json.hpp>
#include <ostream>

#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "client/cli/report_table.h"
#include "core/io/estimate.h"
#include "core/smooth/auto.h"
#include "server/service/loaded_mesh.h"
#include "server/service/options.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

using Json = nlohmann::ordered_json;

/// A report of what is known before smoothing, and what smoothing would take.
struct Forecast {
  v1::SmoothReport report;
  double seconds = 0;  ///< of smoothing, on one core
  std::uint64_t memory_bytes = 0;
};

void describe(const NoiseEstimate& noise, v1::SmoothReport& report) {
  report.mutable_noise()->set_sigma_over_edge(noise.sigma_over_edge);
  report.mutable_noise()->set_kind(std::string(name_of(noise.kind)));
}

Result<> describe_method(const Surface& surface, const ResolvedOptions& options, const RunControl& run,
                         v1::SmoothReport& report) {
  report.set_method(options.method->name);
  for (const auto& [name, value] : options.parameters.values) {
    (*report.mutable_parameters())[name] = to_proto(value);
  }
  if (options.method->name != auto_method().name) {
    describe(estimate_noise(surface, surface.mesh.positions, run), report);
    return run.check();
  }
  const auto plan = plan_auto(surface, {.strength = options.parameters.number("strength")},
                              iteration_options(options.parameters, surface), run);
  if (!plan) return plan.error();
  describe(plan->noise, report);
  report.mutable_choice()->set_method(plan->choice.method);
  report.mutable_choice()->set_reason(plan->choice.reason);
  for (const auto& [name, value] : plan->choice.parameters) {
    (*report.mutable_choice()->mutable_parameters())[name] = to_proto(value);
  }
  return {};
}

/// Stages that the choice takes, else the method's own iterations.
std::optional<double> iterations_of(const v1::SmoothReport& report) {
  const auto& parameters = report.has_choice() ? report.choice().parameters() : report.parameters();
  const auto found = parameters.find("iterations");
  return found == parameters.end() ? std::nullopt : std::optional(found->second.number_value());
}

Result<Forecast> forecast(const SmoothArguments& arguments, const std::string& file, const Console& console) {
  const auto options = smooth_options(arguments, "");
  if (!options) return options.error();
  const auto resolved = resolve_options(*options);
  if (!resolved) return resolved.error();
  const auto bytes = read_input(file, console);
  if (!bytes) return bytes.error();
  const RunControl run = run_control(arguments.place, console);
  Forecast result;
  auto mesh = load_mesh(*bytes, std::nullopt, "", no_limits(), run, *result.report.mutable_timings());
  if (!mesh) return mesh.error();
  result.report.clear_timings();
  result.report.set_version(std::string(version()));
  mesh->summarise(*result.report.mutable_input());
  add_warnings(mesh->warnings(), *result.report.mutable_warnings());
  const auto pinned = pin_vertices(*mesh->document, resolved->pinned, mesh->surface, run);
  if (!pinned) return pinned.error();
  result.report.set_pinned_vertices(*pinned);
  if (auto described = describe_method(mesh->surface, *resolved, run, result.report); !described)
    return described.error();
  const auto vertices = mesh->document->positions().size(), triangles = mesh->document->triangles().size();
  result.seconds = seconds_of(resolved->method->name, triangles, iterations_of(result.report));
  result.memory_bytes =
      estimate(*bytes, std::nullopt).memory_with(resolved->method->work_memory.bytes(vertices, triangles));
  return result;
}

Json json_of(const Forecast& forecast, const std::string& file) {
  Json json = {{"in", file}};
  const Json report = Json::parse(to_json(forecast.report, true));
  for (const char* const key :
       {"version", "method", "parameters", "input", "noise", "choice", "pinnedVertices", "warnings"}) {
    if (report.contains(key)) json[key] = report[key];
  }
  if (json.contains("choice")) json["choice"].erase("sharpBending");  // only smoothing shows it
  json["estimate"] = {{"smoothSeconds", forecast.seconds}, {"memoryBytes", forecast.memory_bytes}};
  return json;
}

}  // namespace

Result<> dry_run(const SmoothArguments& arguments, const std::vector<std::string>& files,
                 const Console& console) {
  Json all = Json::array();
  for (const std::string& file : files) {
    const auto result = forecast(arguments, file, console);
    if (!result)
      return Error{result.error().cause, file + ": " + result.error().message, result.error().field};
    if (arguments.json) {
      all.push_back(json_of(*result, file));
    } else {
      print_forecast(console.out, file, result->report, result->seconds, result->memory_bytes);
    }
  }
  if (arguments.json) {
    console.out << (files.size() == 1 ? all.front() : all).dump(2, ' ', false, Json::error_handler_t::replace)
                << "\n";
  }
  return {};
}

}  // namespace burnish::cli
