// Which file holds bytes that are mapped into memory: another process can map them too, instead of being sent
// a copy.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace burnish {

/// An open file, owned by whoever mapped it, and where in it the bytes begin.
struct FileRange {
  int file = -1;
  std::uint64_t offset = 0;
};

/// Says so of a mapping of the whole file, for as long as it lives. Thread-safe.
class MappedFile {
 public:
  MappedFile() = default;
  MappedFile(std::string_view bytes, int file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  /// The file of bytes that lie whole in one mapping.
  static std::optional<FileRange> holding(std::string_view bytes);

 private:
  const char* begin_ = nullptr;
};

}  // namespace burnish
