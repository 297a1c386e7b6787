#include "client/cli/file_pairs.h"

#include <glob.h>

#include <filesystem>
#include <map>

namespace burnish::cli {
namespace {

namespace fs = std::filesystem;

bool is_pattern(const std::string& name) {
  std::error_code ignored;
  return name.find_first_of("*?[") != std::string::npos && !fs::exists(name, ignored);
}

/// Whether both names lead to one file, be it there or not.
bool same_place(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored);
}

}  // namespace

Result<std::vector<std::string>> expand_globs(const std::vector<std::string>& names) {
  std::vector<std::string> files;
  for (const std::string& name : names) {
    if (!is_pattern(name)) {
      files.push_back(name);
      continue;
    }
    glob_t found{};
    const int failure = ::glob(name.c_str(), 0, nullptr, &found);
    for (std::size_t i = 0; i < found.gl_pathc; ++i) files.emplace_back(found.gl_pathv[i]);
    ::globfree(&found);
    if (failure != 0) return Error{Cause::FileError, "no file matches '" + name + "'"};
  }
  return files;
}

Result<std::vector<FilePair>> pairs_in_folder(const std::vector<std::string>& files,
                                              const std::string& folder, std::optional<Format> format) {
  std::vector<FilePair> pairs;
  std::map<std::string, std::string> taken;  // name of the result -> its file
  for (const std::string& file : files) {
    if (file == "-") return Error{Cause::BadOption, "standard input has no name for its result in a folder"};
    fs::path name = fs::path(file).filename();
    if (format) name.replace_extension(format_name(*format));
    const auto [place, fresh] = taken.emplace(name.string(), file);
    if (!fresh) {
      return Error{Cause::BadOption, "'" + place->second + "' and '" + file + "' would both become '" +
                                         name.string() + "' in the output folder"};
    }
    const fs::path out = fs::path(folder) / name;
    if (same_place(out, file)) {
      return Error{Cause::BadOption,
                   "the result of '" + file + "' would take its place; choose another output folder"};
    }
    pairs.push_back({file, out.string()});
  }
  return pairs;
}

}  // namespace burnish::cli
