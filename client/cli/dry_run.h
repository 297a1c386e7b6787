// `smooth --dry-run`: what a call would do, and what it would take, without doing it.
#pragma once

#include "client/cli/console.h"
#include "client/cli/smooth_arguments.h"

namespace burnish::cli {

/// Reads each file, estimates its noise, asks `auto` for its choice where that is the method, and prints a
/// table for each, or JSON. Nothing is smoothed or written. Errors: those of reading and of the options; the
/// first ends it.
Result<> dry_run(const SmoothArguments& arguments, const std::vector<std::string>& files,
                 const Console& console);

}  // namespace burnish::cli
