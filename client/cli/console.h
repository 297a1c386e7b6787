// Where a command talks to its user.
#pragma once

#include <iostream>
#include <stop_token>

namespace burnish::cli {

struct Console {
  std::ostream& out;             ///< results
  std::ostream& err;             ///< errors, progress
  bool err_is_terminal = false;  ///< show progress
  std::stop_token stop = {};     ///< Ctrl-C
  std::istream& in = std::cin;   ///< a mesh, where a file is named "-"
};

}  // namespace burnish::cli
