// Options that take one of a few words. Help, completion and the manual read the words from the option's type
// name.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace burnish::cli {

/// "gaussian|impulsive|uniform"
template <class T>
std::string names_of(const std::map<std::string, T>& choices) {
  std::string names;
  for (const auto& [name, value] : choices) names.append(names.empty() ? "" : "|").append(name);
  return names;
}

/// Words, in either case, into values. The map must outlive the option.
template <class T>
CLI::Validator choice_of(const std::map<std::string, T>& choices) {
  return CLI::CheckedTransformer(choices, CLI::ignore_case).description("");
}

}  // namespace burnish::cli
