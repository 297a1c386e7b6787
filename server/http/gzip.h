// Content-Encoding, both ways, by zlib.
#pragma once

#include <zlib.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/run/error.h"

namespace burnish {

/// Takes bytes as they come; an error stops whoever brings them.
using ByteSink = std::function<Result<>(std::string_view bytes)>;

/// Whether an Accept-Encoding header likes gzip, and at least as well as no encoding at all.
bool accepts_gzip(std::string_view accept_encoding);

/// Compressed at the fastest level; nothing when `give_up` says so, which is asked every quarter of a
/// megabyte.
std::optional<std::string> gzip(std::string_view bytes, const std::function<bool()>& give_up);

/// Undoes gzip or deflate, told apart by content, piece by piece. Never holds more than a piece.
class Inflater {
 public:
  Inflater();
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Errors: BadRequest for bytes that are neither; the sink's own.
  Result<> feed(std::string_view bytes, const ByteSink& sink);
  /// Errors: BadRequest when the end is missing.
  Result<> finish() const;

 private:
  z_stream stream_{};
  bool begun_ = false;  ///< with a stream that has not ended
};

}  // namespace burnish
