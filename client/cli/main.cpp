#include <unistd.h>

#include <iostream>

#include "client/cli/command_line.h"
#include "client/cli/interrupts.h"
#include "client/cli/memory.h"

int main(int argc, char** argv) {
  burnish::cli::keep_memory();
  burnish::cli::Interrupts interrupts;
  const burnish::cli::Console console{std::cout, std::cerr, isatty(STDERR_FILENO) == 1, interrupts.token()};
  const int code = burnish::cli::run_command_line(argc, argv, console);
  return code != 0 && interrupts.token().stop_requested() ? burnish::cli::kInterrupted : code;
}
