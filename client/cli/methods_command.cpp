#include <memory>
#include <ostream>

#include "client/cli/commands.h"
#include "client/cli/method_help.h"
#include "core/smooth/registry.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

struct MethodsArguments {
  bool json = false, markdown = false;
};

Result<> print_methods(const MethodsArguments& arguments, const Console& console) {
  if (arguments.json) {
    console.out << to_json(list_methods(), false) << "\n";
  } else {
    console.out << (arguments.markdown ? methods_markdown() : method_help());
  }
  return {};
}

}  // namespace

void add_methods_command(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<MethodsArguments>();
  CLI::App* command = app.add_subcommand("methods", "List the methods and their parameters");
  CLI::Option* json = command->add_flag("--json", arguments->json, "Print JSON, as GET /v1/methods answers");
  command->add_flag("--markdown", arguments->markdown, "Print Markdown, as in docs/algorithms.md")
      ->excludes(json);
  command->callback([&chosen, arguments] {
    chosen = [arguments](const Console& console) { return print_methods(*arguments, console); };
  });
}

}  // namespace burnish::cli
