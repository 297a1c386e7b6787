// `smooth` of many files: one after the other, each with all cores; what fails is named, and the rest is
// done.
#pragma once

#include "client/cli/console.h"
#include "client/cli/file_pairs.h"
#include "client/cli/smooth_arguments.h"

namespace burnish::cli {

/// Smooths every pair, with one line of progress, and prints a table of all, or JSON. Errors: the cause of
/// the first file that failed, saying how many did; each was named on console.err before. A stop leaves the
/// rest undone.
Result<> smooth_many(const SmoothArguments& arguments, const std::vector<FilePair>& pairs,
                     const Console& console);

}  // namespace burnish::cli
