// The program `burnish`: reads its arguments, runs one command, names errors by cause.
#pragma once

#include "client/cli/console.h"

namespace burnish::cli {

/// Exit code of a program that Ctrl-C or SIGTERM ended, as shells expect it.
inline constexpr int kInterrupted = 130;

/// Runs the command of the arguments. An error is one line on console.err, "burnish: CODE: message".
/// Returns 0, or the cause's exit code of server/status_map.h: 2 bad call, 3 bad mesh, 4 refused or out of
/// time, 5 server, 6 files. Never throws.
int run_command_line(int argc, const char* const* argv, const Console& console);

}  // namespace burnish::cli
