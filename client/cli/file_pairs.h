// Many files of one call: which they are, and where their results go.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/format.h"
#include "core/run/error.h"

namespace burnish::cli {

struct FilePair {
  std::string in, out;
};

/// The files that the names stand for, in their order: a name with *, ? or [ that is no file is a pattern, as
/// in a shell, for those that do not expand it themselves; its files come by name. Errors: FileError for a
/// pattern that nothing matches.
Result<std::vector<std::string>> expand_globs(const std::vector<std::string>& names);

/// Each file's result in the folder, under the file's own name, with the ending of `format` where one is
/// given. Errors: BadOption when two would have the same name, when one would take the place of its own file,
/// and for standard input, which has no name.
Result<std::vector<FilePair>> pairs_in_folder(const std::vector<std::string>& files,
                                              const std::string& folder, std::optional<Format> format);

}  // namespace burnish::cli
