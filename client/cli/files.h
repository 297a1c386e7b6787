// Reading and writing whole files. What is written appears complete or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "client/cli/console.h"
#include "core/run/error.h"

namespace burnish::cli {

/// Errors: FileError, naming the file and the system's reason.
Result<std::string> read_file(const std::filesystem::path& path);

/// Tells before long work whether write_file() could succeed; changes nothing. Errors: FileError.
Result<> check_writable(const std::filesystem::path& path);

/// Writes next to `path` and renames, so a failure leaves the old file whole. Follows a symbolic link, keeps
/// an existing file's permissions; pipes and devices are written directly. Errors: FileError.
Result<> write_file(const std::filesystem::path& path, std::string_view bytes);

/// The same, where the name "-" stands for standard input and standard output.
Result<std::string> read_input(const std::string& name, const Console& console);
Result<> check_output(const std::string& name);
Result<> write_output(const std::string& name, std::string_view bytes, const Console& console);

}  // namespace burnish::cli
