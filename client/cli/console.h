// Where a command talks to its user.
#pragma once

#include <iostream>
#include <stop_token>
#include <string_view>

#include "core/run/error.h"

namespace burnish::cli {

struct Console {
  std::ostream& out;             ///< results
  std::ostream& err;             ///< errors, progress
  bool err_is_terminal = false;  ///< show progress
  std::stop_token stop = {};     ///< Ctrl-C
  std::istream& in = std::cin;   ///< a mesh, where a file is named "-"
  bool colors = false;           ///< of errors
};

/// The console of this process. Progress and colours are for terminals that understand them (TERM is not
/// "dumb"), colours only without NO_COLOR.
Console process_console(std::stop_token stop);

/// "burnish: place: code: message" on console.err.
void print_error(const Console& console, const Error& error, std::string_view place = {});

}  // namespace burnish::cli
