#include "server/mapped_files.h"

#include <map>
#include <mutex>
#include <utility>

namespace burnish {
namespace {

struct Mappings {
  std::mutex mutex;
  std::map<const char*, std::pair<std::string_view, int>> by_begin;
};

Mappings& mappings() {
  static Mappings all;
  return all;
}

}  // namespace

MappedFile::MappedFile(std::string_view bytes, int file) : begin_(bytes.data()) {
  Mappings& all = mappings();
  const std::lock_guard lock(all.mutex);
  all.by_begin[begin_] = {bytes, file};
}

MappedFile::~MappedFile() {
  if (!begin_) return;
  Mappings& all = mappings();
  const std::lock_guard lock(all.mutex);
  all.by_begin.erase(begin_);
}

std::optional<FileRange> MappedFile::holding(std::string_view bytes) {
  Mappings& all = mappings();
  const std::lock_guard lock(all.mutex);
  const auto after = all.by_begin.upper_bound(bytes.data());
  if (after == all.by_begin.begin()) return {};
  const auto& [whole, file] = std::prev(after)->second;
  const auto offset = static_cast<std::uint64_t>(bytes.data() - whole.data());
  if (offset + bytes.size() > whole.size()) return {};
  return FileRange{file, offset};
}

}  // namespace burnish
