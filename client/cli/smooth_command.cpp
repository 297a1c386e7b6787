#include <map>
#include <memory>
#include <ostream>

#include "client/cli/choices.h"
#include "client/cli/commands.h"
#include "client/cli/dry_run.h"
#include "client/cli/file_pairs.h"
#include "client/cli/files.h"
#include "client/cli/method_help.h"
#include "client/cli/report_table.h"
#include "client/cli/smooth_many.h"
#include "client/cli/smooth_run.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

/// Everything that can be refused before long work starts.
Result<> check_outputs(const SmoothArguments& arguments, const std::string& out) {
  const bool report_to_output = arguments.json || arguments.report == "-";
  if (out == "-" && report_to_output) {
    return Error{Cause::BadOption, "standard output takes the mesh or the report, not both"};
  }
  if (auto writable = check_output(out); !writable) return writable;
  return arguments.report.empty() ? Result<>() : check_output(arguments.report);
}

/// The mesh, and the report: as JSON where it was asked for, as a table where there is room for one.
Result<> write_results(const SmoothArguments& arguments, const std::string& out, const Smoothed& smoothed,
                       const Console& console) {
  if (Result<> written = write_output(out, smoothed.mesh, console); !written) return written;
  const std::string json = to_json(smoothed.report, false) + "\n";
  if (arguments.json || arguments.report == "-") console.out << json;
  if (!arguments.json)
    print_report(arguments.report == "-" || out == "-" ? console.err : console.out, smoothed.report);
  if (arguments.report.empty() || arguments.report == "-") return {};
  return write_file(arguments.report, json);
}

Result<> smooth_one(const SmoothArguments& arguments, const Console& console) {
  const std::string& in = arguments.files[0];
  const std::string& out = arguments.files[1];
  if (auto fine = check_outputs(arguments, out); !fine) return fine;
  const auto smoothed = smooth_file(arguments, in, out, "", console);
  if (!smoothed) return smoothed.error();
  return write_results(arguments, out, *smoothed, console);
}

Result<> smooth_into_folder(const SmoothArguments& arguments, const std::vector<std::string>& files,
                            const Console& console) {
  if (!arguments.reference.empty())
    return Error{Cause::BadOption, "--reference is for one mesh, not for a folder of them"};
  const auto format = arguments.output_format ? from_proto(*arguments.output_format) : std::nullopt;
  const auto pairs = pairs_in_folder(files, arguments.output_folder, format);
  if (!pairs) return pairs.error();
  if (auto options = smooth_options(arguments, ""); !options) return options.error();
  return smooth_many(arguments, *pairs, console);
}

Result<> smooth(const SmoothArguments& arguments, const Console& console) {
  const bool folder = !arguments.output_folder.empty();
  if (!folder && !arguments.dry_run && arguments.files.size() != 2) {
    return Error{Cause::BadOption, "smooth takes IN and OUT, or files and --output-folder; these are " +
                                       std::to_string(arguments.files.size()) +
                                       (arguments.files.size() == 1 ? " file" : " files")};
  }
  if (arguments.dry_run && !folder && arguments.files.size() == 2)
    return dry_run(arguments, {arguments.files[0]}, console);
  if (!folder && !arguments.dry_run) return smooth_one(arguments, console);
  const auto files = expand_globs(arguments.files);
  if (!files) return files.error();
  return arguments.dry_run ? dry_run(arguments, *files, console)
                           : smooth_into_folder(arguments, *files, console);
}

void add_files(CLI::App* command, SmoothArguments& arguments) {
  command
      ->add_option(
          "FILES", arguments.files,
          "IN, a mesh file (" + list_of_format_names() +
              "), and OUT, left as it was when anything fails; - for standard input and output. With "
              "--output-folder any number of files, or patterns such as 'scans/*.obj'")
      ->type_name("FILE")
      ->required();
  command
      ->add_option(
          "--output-folder", arguments.output_folder,
          "Smooth every file into this folder, under its own name; what fails is named, the rest is done")
      ->type_name("FOLDER");
  command
      ->add_option("--reference", arguments.reference, "Measure the errors against this mesh, not against IN")
      ->type_name("FILE");
  command
      ->add_option(
          "--report", arguments.report,
          "Write the report as JSON to this file; - for standard output, the table then goes to stderr")
      ->type_name("FILE");
  command->add_flag("--json", arguments.json, "Print the report as JSON, and no table");
}

void add_method(CLI::App* command, SmoothArguments& arguments) {
  command->add_option("--method", arguments.method, "Name of a method below")->type_name("METHOD");
  command->add_option("--iterations", arguments.iterations, "Number of iterations");
  command->add_option("--set", arguments.assignments, "name=value of a parameter below; may be repeated")
      ->type_name("PARAMETER")
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
      ->add_option("--pin-group", arguments.pinned_group,
                   "Vertices of this group of an OBJ, or mesh or node of a GLB, stay as well")
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
      ->transform(choice_of(kFormats))
      ->type_name(names_of(kFormats));
  command
      ->add_option("--draco-method", arguments.draco_method,
                   "sequential (keeps the order) or edgebreaker (smaller); default: as IN, else sequential")
      ->transform(choice_of(kMethods))
      ->type_name(names_of(kMethods));
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
  CLI::Option* const server = add_place(command, arguments->place);
  command
      ->add_flag("--dry-run", arguments->dry_run,
                 "Tell the noise of IN, what the method (auto: its choice) would do, and about the time and "
                 "memory that it would take; write nothing")
      ->excludes(server);
  add_output(command, *arguments);
  command->footer([] { return "Methods and their parameters (--set):\n" + method_help(); });
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return smooth(*arguments, console); };
  });
}

}  // namespace burnish::cli
