// The registry of methods as plain text.
#pragma once

#include <string>

namespace burnish::cli {

/// Every method with its parameters: default, range, unit, text.
std::string method_help();

}  // namespace burnish::cli
