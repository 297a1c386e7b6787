// What a user wants every time: from the environment and from a file, below the flags of the call.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/run/error.h"

namespace burnish::cli {

/// Gives the command's options that the call leaves open the values of BURNISH_SERVER and its like, or else
/// of the file: one JSON object with the keys "server", "method", "retries", "timeout", "threads",
/// "token-file", "tls-ca", "tls-certificate" and "tls-key", as the flags take them. Keys that this command
/// has no flag for, and those that the call rules out (a server beside --local), are passed over. `file`: its
/// path, which must be there; empty: BURNISH_CONFIG, else burnish/config.json in the user's configuration
/// folder, where there is one. Errors: BadOption, naming the variable, or file and key.
Result<> apply_preferences(CLI::App& command, const std::string& file);

/// "$XDG_CONFIG_HOME/burnish/config.json" or "$HOME/.config/burnish/config.json"; empty when neither variable
/// is set.
std::string default_preferences_file();

/// The keys of the file, and the variable that goes before one: "server", BURNISH_SERVER; empty where there
/// is none.
std::vector<std::string> preference_keys();
std::string preference_variable(const std::string& key);

}  // namespace burnish::cli
