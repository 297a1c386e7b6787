// The registry of methods as plain text.
#pragma once

#include <string>

#include "core/smooth/registry.h"

namespace burnish::cli {

std::string default_text(const ParameterSpec& spec);
std::string range_text(const ParameterSpec& spec);  ///< "0 to 1 mean edge lengths", "fixed|free"

/// Every method with its parameters: default, range, unit, text.
std::string method_help();

}  // namespace burnish::cli
