#include <ostream>
#include <sstream>

#include "client/cli/command_tree.h"
#include "client/cli/commands.h"
#include "client/cli/method_help.h"
#include "client/cli/preferences.h"
#include "core/smooth/registry.h"

namespace burnish::cli {
namespace {

/// Text as roff shows it: hyphens that can be copied, nothing that looks like a request.
std::string escaped(const std::string& text) {
  std::string result;
  bool at_start = true;
  for (const char c : text) {
    if (at_start && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    at_start = c == '\n';
  }
  return result;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string value_of(const CLI::Option& option) {
  if (!takes_value(option) || is_positional(option)) return "";
  const std::string type = option.get_type_name();
  return " " + (words_of(option).empty() ? italic(type.substr(0, type.find(':'))) : escaped(type));
}

void print_option(std::ostream& out, const CLI::Option& option) {
  out << ".TP\n"
      << (is_positional(option) ? italic(names_of(option)) : bold(names_of(option))) << value_of(option)
      << "\n"
      << escaped(option.get_description());
  if (!option.get_default_str().empty() && takes_value(option))
    out << " (" << escaped(option.get_default_str()) << ")";
  out << "\n";
}

void print_command(std::ostream& out, const CLI::App& command) {
  out << ".SS " << bold("burnish " + command.get_name());
  for (const CLI::Option* option : command.get_options()) {
    if (is_positional(*option)) out << " " << italic(names_of(*option));
  }
  out << "\n" << escaped(command.get_description()) << ".\n";
  for (const CLI::Option* option : command.get_options()) print_option(out, *option);
}

void print_methods(std::ostream& out) {
  out << ".SH METHODS\n";
  for (const Method& method : methods()) {
    out << ".SS " << bold(method.name) << "\n"
        << escaped(method.summary) << "\n.br\n"
        << escaped(method.reference) << "\n";
    for (const ParameterSpec& spec : method.parameters) {
      out << ".TP\n"
          << bold(spec.name) << "=" << escaped(default_text(spec)) << "\n"
          << escaped(range_text(spec) + ". " + spec.text) << "\n";
    }
  }
}

constexpr const char* kExamples[] = {
    "burnish smooth scan.obj smooth.obj",
    "burnish smooth 'scans/*.obj' --output-folder smoothed",
    "burnish smooth scan.obj --dry-run",
    "zcat scan.obj.gz | burnish smooth - - | gzip > smooth.obj.gz",
    "burnish compare original.obj smooth.obj --heatmap distances.ply",
    "burnish smooth scan.drc smooth.drc --method taubin --set lambda=0.4 --server 127.0.0.1:50051",
};

void print_surroundings(std::ostream& out) {
  out << ".SH EXIT STATUS\n"
         "0 done, 2 bad call, 3 bad mesh, 4 refused or out of time, 5 server, 6 files, 130 Ctrl\\-C. Of many "
         "files: that of the\n"
         "first that failed.\n"
         ".SH ENVIRONMENT\n";
  const auto variable = [&](const std::string& name, const std::string& text) {
    out << ".TP\n" << bold(name) << "\n" << escaped(text) << "\n";
  };
  for (const std::string& key : preference_keys()) {
    const std::string name = preference_variable(key);
    if (!name.empty()) variable(name, "As --" + key + ", which goes before it.");
  }
  variable("BURNISH_TOKEN", "The server's token.");
  variable("BURNISH_CONFIG", "As --config, which goes before it.");
  variable("NO_COLOR", "When it is set, nothing is coloured.");
  variable("TRACEPARENT", "The W3C trace that calls are a part of.");
  out << ".SH FILES\n.TP\n"
      << italic("$XDG_CONFIG_HOME/burnish/config.json") << ", or in " << italic("~/.config") << "\n"
      << "One JSON object with what the call and the environment leave open:\n";
  std::string between;
  for (const std::string& key : preference_keys()) {
    out << between << bold(key);
    between = ", ";
  }
  out << ", as the options of these names take them. Unknown names and wrong types are errors.\n.SH "
         "EXAMPLES\n.nf\n";
  for (const char* const example : kExamples) out << escaped(example) << "\n";
  out << ".fi\n";
}

void print_man(std::ostream& out, const CLI::App& app) {
  const std::string name = app.version();  // "burnish 0.1.0"
  out << ".TH BURNISH 1 \"\" \"" << escaped(name) << "\" \"Burnish\"\n"
      << ".SH NAME\nburnish \\- smooths scanned triangle meshes without destroying their features\n"
      << ".SH SYNOPSIS\n"
      << bold("burnish") << " [" << bold("--config") << " " << italic("FILE") << "] " << italic("COMMAND")
      << " ...\n"
      << ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(app)) print_command(out, *command);
  print_methods(out);
  print_surroundings(out);
}

}  // namespace

void add_man_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("man", "Print the manual page, for man -l");
  command->callback([&app, &chosen] {
    chosen = [&app](const Console& console) {
      print_man(console.out, app);
      return Result<>();
    };
  });
}

}  // namespace burnish::cli
