#include "client/cli/console.h"

#include <unistd.h>

#include <cstdlib>
#include <string>
#include <utility>

namespace burnish::cli {
namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

Console process_console(std::stop_token stop) {
  const bool terminal = isatty(STDERR_FILENO) == 1 && variable("TERM") != "dumb";
  return {.out = std::cout,
          .err = std::cerr,
          .err_is_terminal = terminal,
          .stop = std::move(stop),
          .in = std::cin,
          .colors = terminal && variable("NO_COLOR").empty()};
}

void print_error(const Console& console, const Error& error, std::string_view place) {
  const char* const red = console.colors ? "\x1b[31m" : "";
  const char* const plain = console.colors ? "\x1b[0m" : "";
  console.err << red << "burnish:" << plain << " " << place << cause_code(error.cause) << ": "
              << error.message << std::endl;
}

}  // namespace burnish::cli
