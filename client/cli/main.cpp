#include "client/cli/command_line.h"
#include "client/cli/interrupts.h"
#include "client/cli/memory.h"

int main(int argc, char** argv) {
  burnish::cli::keep_memory();
  burnish::cli::Interrupts interrupts;
  const int code =
      burnish::cli::run_command_line(argc, argv, burnish::cli::process_console(interrupts.token()));
  return code != 0 && interrupts.token().stop_requested() ? burnish::cli::kInterrupted : code;
}
