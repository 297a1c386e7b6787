#include <memory>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/files.h"
#include "client/cli/mesh_files.h"
#include "client/cli/report_table.h"
#include "server/service/compare.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

struct CompareArguments {
  std::string reference, mesh;
  bool json = false;
};

Result<> compare(const CompareArguments& arguments, const Console& console) {
  Result<std::string> reference = read_file(arguments.reference);
  if (!reference) return reference.error();
  Result<std::string> mesh = read_file(arguments.mesh);
  if (!mesh) return mesh.error();
  const RunControl run{.stop = console.stop, .threads = 0};
  Result<v1::MeshErrors> errors = compare_meshes(*reference, *mesh, no_limits(), run);
  if (!errors) return errors.error();
  if (arguments.json) {
    console.out << to_json(*errors, false) << "\n";
  } else {
    print_errors(console.out, *errors);
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
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return compare(*arguments, console); };
  });
}

}  // namespace burnish::cli
