#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "client/cli/method_help.h"
#include "client/cli/place.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report_table.h"
#include "client/smoothing_client.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

struct SmoothArguments {
  std::string in, out, reference, report, method;
  Place place;
  std::optional<std::uint32_t> iterations;
  std::vector<std::string> assignments;  // name=value
  std::vector<std::uint32_t> pinned_vertices;
  std::string pinned_group, pinned_attribute;
  std::optional<v1::MeshFormat> output_format;
  v1::DracoMethod draco_method = v1::DRACO_METHOD_UNSPECIFIED;
  std::optional<std::uint32_t> position_bits, normal_bits, texture_coordinate_bits, color_bits, generic_bits,
      speed;
};

/// The files that go in.
struct Inputs {
  std::string mesh, reference;
};

/// What comes out of either mode.
struct Smoothed {
  std::string mesh;
  v1::SmoothReport report;
};

/// A number where the text is one, else a choice's name: the server that runs the method knows which it
/// wants.
google::protobuf::Value value_of(const std::string& text) {
  google::protobuf::Value value;
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, problem] = std::from_chars(text.data(), end, number);
  if (problem == std::errc{} && stop == end && std::isfinite(number)) {
    value.set_number_value(number);
  } else {
    value.set_string_value(text);
  }
  return value;
}

Result<> set_parameters(v1::SmoothOptions& options, const std::vector<std::string>& assignments) {
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    if (equals == 0 || equals == std::string::npos) {
      return Error{Cause::BadOption, "--set takes name=value, not '" + assignment + "'", "set"};
    }
    const std::string name = assignment.substr(0, equals);
    if (!options.mutable_parameters()->insert({name, value_of(assignment.substr(equals + 1))}).second) {
      return Error{Cause::BadOption, "'" + name + "' is set twice", name};
    }
  }
  return {};
}

v1::PinnedVertices pinned(const SmoothArguments& arguments) {
  v1::PinnedVertices pinned;
  pinned.mutable_vertices()->Assign(arguments.pinned_vertices.begin(), arguments.pinned_vertices.end());
  pinned.set_group(arguments.pinned_group);
  pinned.set_attribute(arguments.pinned_attribute);
  return pinned;
}

v1::OutputOptions output_options(const SmoothArguments& arguments) {
  v1::OutputOptions output;
  const std::optional<Format> by_name = format_of_name(arguments.out);
  output.set_format(
      arguments.output_format.value_or(by_name ? to_proto(*by_name) : v1::MESH_FORMAT_UNSPECIFIED));
  v1::DracoOptions draco;
  draco.set_method(arguments.draco_method);
  if (arguments.position_bits) draco.set_position_bits(*arguments.position_bits);
  if (arguments.normal_bits) draco.set_normal_bits(*arguments.normal_bits);
  if (arguments.texture_coordinate_bits)
    draco.set_texture_coordinate_bits(*arguments.texture_coordinate_bits);
  if (arguments.color_bits) draco.set_color_bits(*arguments.color_bits);
  if (arguments.generic_bits) draco.set_generic_bits(*arguments.generic_bits);
  if (arguments.speed) draco.set_speed(*arguments.speed);
  if (draco.ByteSizeLong() > 0) *output.mutable_draco() = draco;
  return output;
}

Result<v1::SmoothOptions> smooth_options(const SmoothArguments& arguments) {
  v1::SmoothOptions options;
  options.set_method(arguments.method);
  if (arguments.iterations) options.set_iterations(*arguments.iterations);
  if (Result<> set = set_parameters(options, arguments.assignments); !set) return set.error();
  if (const auto pins = pinned(arguments); pins.ByteSizeLong() > 0) *options.mutable_pinned() = pins;
  *options.mutable_output() = output_options(arguments);
  return options;
}

Result<Smoothed> smooth_here(const SmoothArguments& arguments, const Inputs& inputs,
                             v1::SmoothOptions options, const Console& console) {
  ProgressBar bar(console.err);
  SmoothJob job{.mesh = inputs.mesh,
                .reference = inputs.reference,
                .options = std::move(options),
                .request_id = "local"};
  if (console.err_is_terminal) {
    job.progress = [&bar](v1::SmoothStage stage, double fraction) { bar.show(stage, fraction); };
  }
  auto result = SmoothService({.mesh = no_limits()}).smooth(job, run_control(arguments.place, console));
  if (!result) return result.error();
  return Smoothed{std::move(result->mesh), std::move(result->report)};
}

Result<Smoothed> smooth_there(const SmoothArguments& arguments, Inputs inputs, v1::SmoothOptions options,
                              const Console& console) {
  v1::SmoothRequest request;
  request.set_mesh(std::move(inputs.mesh));
  request.set_reference(std::move(inputs.reference));
  *request.mutable_options() = std::move(options);
  ProgressBar bar(console.err);
  client::CallOptions call = call_options(arguments.place, console);
  if (console.err_is_terminal) {
    call.progress = [&bar](const v1::SmoothProgress& now) { bar.show(now.stage(), now.fraction()); };
  }
  const auto client = connect(arguments.place);
  if (!client) return client.error();
  auto reply = client->smooth(request, call);
  if (!reply) return error_from(reply.error(), arguments.place);
  return Smoothed{std::move(*reply->mutable_mesh()), std::move(*reply->mutable_report())};
}

/// Everything that can be refused before long work starts, and the bytes to work on.
Result<Inputs> read_inputs(const SmoothArguments& arguments) {
  if (Result<> writable = check_writable(arguments.out); !writable) return writable.error();
  if (!arguments.report.empty() && arguments.report != "-") {
    if (Result<> writable = check_writable(arguments.report); !writable) return writable.error();
  }
  Inputs inputs;
  Result<std::string> mesh = read_file(arguments.in);
  if (!mesh) return mesh.error();
  inputs.mesh = std::move(*mesh);
  if (arguments.reference.empty()) return inputs;
  Result<std::string> reference = read_file(arguments.reference);
  if (!reference) return reference.error();
  if (reference->empty())
    return Error{Cause::EmptyMesh, "the reference '" + arguments.reference + "' is empty"};
  inputs.reference = std::move(*reference);
  return inputs;
}

Result<> write_results(const SmoothArguments& arguments, const Smoothed& smoothed, const Console& console) {
  if (Result<> written = write_file(arguments.out, smoothed.mesh); !written) return written;
  const std::string json = to_json(smoothed.report, false) + "\n";
  if (arguments.report == "-") {
    print_report(console.err, smoothed.report);
    console.out << json;
    return {};
  }
  print_report(console.out, smoothed.report);
  return arguments.report.empty() ? Result<>() : write_file(arguments.report, json);
}

Result<> smooth(const SmoothArguments& arguments, const Console& console) {
  Result<v1::SmoothOptions> options = smooth_options(arguments);
  if (!options) return options.error();
  Result<Inputs> inputs = read_inputs(arguments);
  if (!inputs) return inputs.error();
  Result<Smoothed> smoothed = arguments.place.server.empty()
                                  ? smooth_here(arguments, *inputs, std::move(*options), console)
                                  : smooth_there(arguments, std::move(*inputs), std::move(*options), console);
  if (!smoothed) return smoothed.error();
  return write_results(arguments, *smoothed, console);
}

void add_files(CLI::App* command, SmoothArguments& arguments) {
  command->add_option("IN", arguments.in, "Mesh file: " + list_of_format_names())->required();
  command->add_option("OUT", arguments.out, "File to write; left as it was when anything fails")->required();
  command->add_option("--reference", arguments.reference,
                      "Measure the errors against this mesh, not against IN");
  command->add_option(
      "--report", arguments.report,
      "Write the report as JSON to this file; - for standard output, the table then goes to stderr");
}

void add_method(CLI::App* command, SmoothArguments& arguments) {
  command->add_option("--method", arguments.method, "Name of a method below");
  command->add_option("--iterations", arguments.iterations, "Number of iterations");
  command->add_option("--set", arguments.assignments, "name=value of a parameter below; may be repeated")
      ->allow_extra_args(false);
}

void add_pins(CLI::App* command, SmoothArguments& arguments) {
  command
      ->add_option("--pin", arguments.pinned_vertices,
                   "Vertices that stay where they are, counted from 0 as in the file: 0,1,2; may be repeated")
      ->delimiter(',')
      ->allow_extra_args(false);
  const auto named = CLI::Validator(
      [](const std::string& name) { return name.empty() ? "needs a name" : std::string(); }, "NAME");
  command
      ->add_option("--pin-group", arguments.pinned_group, "Vertices of this OBJ group's faces stay as well")
      ->check(named);
  command
      ->add_option("--pin-attribute", arguments.pinned_attribute,
                   "Points where this Draco attribute (by name or unique id) is not 0 stay as well")
      ->check(named);
}

void add_output(CLI::App* command, SmoothArguments& arguments) {
  static const auto kFormats = [] {
    std::map<std::string, v1::MeshFormat> all;
    for (const FormatTraits& each : formats()) all.emplace(each.name, to_proto(each.format));
    return all;
  }();
  static const std::map<std::string, v1::DracoMethod> kMethods = {
      {"sequential", v1::DRACO_METHOD_SEQUENTIAL}, {"edgebreaker", v1::DRACO_METHOD_EDGEBREAKER}};
  command
      ->add_option("--output-format", arguments.output_format,
                   list_of_format_names() + "; default: OUT's extension, else as IN")
      ->transform(CLI::CheckedTransformer(kFormats, CLI::ignore_case).description("TEXT"));
  command
      ->add_option("--draco-method", arguments.draco_method,
                   "sequential (keeps the order) or edgebreaker (smaller); default: as IN, else sequential")
      ->transform(CLI::CheckedTransformer(kMethods, CLI::ignore_case).description("TEXT"));
  const std::string bits = ", 0 = lossless; default: as IN, else lossless";
  command->add_option("--position-bits", arguments.position_bits, "Draco: bits per coordinate" + bits);
  command->add_option("--normal-bits", arguments.normal_bits, "Draco: bits per normal" + bits);
  command->add_option("--texture-coordinate-bits", arguments.texture_coordinate_bits,
                      "Draco: bits per texture coordinate" + bits);
  command->add_option("--color-bits", arguments.color_bits, "Draco: bits per float colour component" + bits);
  command->add_option("--generic-bits", arguments.generic_bits,
                      "Draco: bits of other float attributes" + bits);
  command->add_option("--speed", arguments.speed, "Draco: 0 (smallest) to 10 (fastest); default 5");
}

}  // namespace

void add_smooth_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<SmoothArguments>();
  CLI::App* command = app.add_subcommand("smooth", "Smooth a mesh and report what changed");
  add_files(command, *arguments);
  add_method(command, *arguments);
  add_pins(command, *arguments);
  add_place(command, arguments->place);
  add_output(command, *arguments);
  command->footer([] { return "Methods and their parameters (--set):\n" + method_help(); });
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return smooth(*arguments, console); };
  });
}

}  // namespace burnish::cli
