// One mesh through `smooth`.
#pragma once

#include <string>

#include "client/cli/console.h"
#include "client/cli/smooth_arguments.h"

namespace burnish::cli {

struct Smoothed {
  std::string mesh;
  v1::SmoothReport report;
};

/// Reads, smooths in this process or by the server, and gives what is to be written to `out`. `title` leads
/// the line of progress. Errors: those of SmoothService::smooth(), of the client, and FileError.
Result<Smoothed> smooth_file(const SmoothArguments& arguments, const std::string& in, const std::string& out,
                             const std::string& title, const Console& console);

}  // namespace burnish::cli
