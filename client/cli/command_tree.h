// The commands and their options as the application declares them, for what is made from them: completion and
// manual.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace burnish::cli {

/// In the order of the help.
std::vector<const CLI::App*> commands_of(const CLI::App& app);

/// "--set", "-h,--help", or the name of a positional.
std::string names_of(const CLI::Option& option);
/// All of its flags: "-h", "--help"; none for a positional.
std::vector<std::string> flags_of(const CLI::Option& option);
bool takes_value(const CLI::Option& option);
bool is_positional(const CLI::Option& option);

/// The values that there are, when the type name lists them as "row|each"; else none.
std::vector<std::string> words_of(const CLI::Option& option);

}  // namespace burnish::cli
