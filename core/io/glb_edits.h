// Private to the GLB codec: what writing changes in a file's buffers and in the text of its JSON.
#pragma once

#include <map>

#include "core/io/glb_document.h"

namespace burnish {

/// The file's buffers; those that change are copied first.
class GlbBuffers {
 public:
  explicit GlbBuffers(const GlbFile& file) : file_(file) {}

  std::string& change(Index buffer) {
    const auto [copy, is_new] = changed_.try_emplace(buffer);
    if (is_new) copy->second = file_.buffer(buffer);
    return copy->second;
  }
  const std::map<Index, std::string>& changed() const { return changed_; }

 private:
  const GlbFile& file_;
  std::map<Index, std::string> changed_;
};

/// Numbers of the JSON that get another value. Members that the file leaves out stay out.
struct GlbEdits {
  struct Accessor {
    std::optional<std::uint64_t> count = {};
    std::optional<Vec3d> low = {}, high = {};  ///< "min" and "max"
  };
  struct View {
    std::uint64_t offset = 0, length = 0;
  };
  struct Buffer {
    std::uint64_t length = 0;
    std::optional<std::string> uri = {};
  };
  std::map<Index, Accessor> accessors = {};
  std::map<Index, View> views = {};
  std::map<Index, Buffer> buffers = {};

  /// The text with these numbers in place of its own; all else as it was, and numbers that are right already.
  std::string apply(std::string_view json) const;
};

/// The bytes of a buffer view that others, of another length, take the place of.
struct GlbReplacement {
  Index view = 0;
  GlbView place = {};
  std::string bytes = {};
};

/// Puts them in place, and moves the views behind them by multiples of four bytes. Errors: CannotEncode (a
/// view holds both such bytes and others, or cannot be read, so not moved).
Result<> replace_views(const GlbFile& file, std::vector<GlbReplacement> replacements, GlbBuffers& buffers,
                       GlbEdits& edits);

/// Decimal text that reads back as the same number.
std::string json_number(double value);

}  // namespace burnish
