// Where a command talks to its user.
#pragma once

#include <iosfwd>
#include <stop_token>

namespace burnish::cli {

struct Console {
  std::ostream& out;             ///< results
  std::ostream& err;             ///< errors, progress
  bool err_is_terminal = false;  ///< show progress
  std::stop_token stop = {};     ///< Ctrl-C
};

}  // namespace burnish::cli
