#include <memory>
#include <ostream>
#include <sstream>

#include "client/cli/command_tree.h"
#include "client/cli/commands.h"
#include "core/smooth/registry.h"

namespace burnish::cli {
namespace {

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string line;
  for (const std::string& word : words) line.append(line.empty() ? "" : between).append(word);
  return line;
}

std::string names_of_methods() {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.push_back(method.name);
  return joined(names, " ");
}

/// "lambda= mu=", by the method that the line names.
std::string parameters_by_method() {
  std::string cases;
  for (const Method& method : methods()) {
    std::vector<std::string> names;
    for (const ParameterSpec& spec : method.parameters) names.push_back(spec.name + "=");
    cases += "        " + method.name + ") _burnish_words '" + joined(names, " ") + "' ;;\n";
  }
  return "compopt -o nospace 2>/dev/null\n      case $method in\n" + cases + "      esac";
}

/// What completes the option's value, as a line of bash; empty when nobody can know.
std::string values(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  if (const auto words = words_of(option); !words.empty())
    return "_burnish_words '" + joined(words, " ") + "'";
  if (type == "FILE") return "_burnish_files -f";
  if (type == "FOLDER") return "_burnish_files -d";
  if (type == "METHOD") return "_burnish_words '" + names_of_methods() + "'";
  if (type == "PARAMETER") return parameters_by_method();
  return "";
}

/// One command: what follows the options that take a value, else its options and positionals.
std::string case_of(const CLI::App& command) {
  std::string cases, others;
  std::vector<std::string> flags;
  for (const CLI::Option* option : command.get_options()) {
    if (is_positional(*option)) {
      others = values(*option);
      continue;
    }
    const auto names = flags_of(*option);
    flags.insert(flags.end(), names.begin(), names.end());
    if (!takes_value(*option)) continue;
    const std::string value = values(*option);
    cases += "    " + joined(names, "|") + ") " + (value.empty() ? ":" : value) + " ;;\n";
  }
  flags.emplace_back("--config");
  return "  " + command.get_name() + ") case $before in\n    --config) _burnish_files -f ;;\n" + cases +
         "    *) if [[ $word == -* ]]; then _burnish_words '" + joined(flags, " ") + "'" +
         (others.empty() ? "" : "; else " + others) + "; fi ;;\n    esac ;;\n";
}

constexpr const char* kHelpers = R"(_burnish_words() {
  local line
  while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -W "$1" -- "$word")
}
_burnish_files() {
  local line
  compopt -o filenames 2>/dev/null
  while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen "$1" -- "$word")
}
)";

void print_bash(std::ostream& out, const CLI::App& app) {
  std::vector<std::string> names;
  std::string cases;
  for (const CLI::App* command : commands_of(app)) {
    names.push_back(command->get_name());
    cases += case_of(*command);
  }
  out << "# Completion of burnish " << app.version().substr(app.version().rfind(' ') + 1)
      << " for bash, made by: burnish completion bash\n"
      << kHelpers << "_burnish() {\n"
      << "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= method="
      << methods().front().name << " i\n"
      << "  COMPREPLY=()\n"
      << "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      << "    case ${COMP_WORDS[i]} in\n"
      << "      --method) method=${COMP_WORDS[i+1]} ;;\n"
      << "      " << joined(names, "|") << ") [[ $command ]] || command=${COMP_WORDS[i]} ;;\n"
      << "    esac\n  done\n  case $command in\n"
      << "  '') if [[ $before == --config ]]; then _burnish_files -f; else _burnish_words '"
      << joined(names, " ") << " --help --version --config'; fi ;;\n"
      << cases << "  esac\n}\ncomplete -F _burnish burnish\n";
}

}  // namespace

void add_completion_command(CLI::App& app, Command& chosen) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("completion", "Print what completes burnish's commands and options in a shell");
  command->add_option("SHELL", *shell, "bash")
      ->type_name("bash|")
      ->required()
      ->check(CLI::IsMember({"bash"}).description(""));
  command->footer("For this session: source <(burnish completion bash)");
  command->callback([&app, &chosen, shell] {
    chosen = [&app](const Console& console) {
      print_bash(console.out, app);
      return Result<>();
    };
  });
}

}  // namespace burnish::cli
