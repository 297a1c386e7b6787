// multipart/form-data by the HTTP library's parser. Includes its header: only for conversation.cpp.
#pragma once

#include <httplib.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/body_reader.h"

namespace burnish {

/// Feeds a form's parts into `parts`, which must outlive it.
class FormParser {
 public:
  FormParser(std::string boundary, BodyParts& parts) : parts_(parts) {
    parser_.set_boundary(std::move(boundary));
  }

  /// Errors: BadRequest, and those of BodyParts.
  Result<> feed(std::string_view bytes) {
    while (!bytes.empty() && !parser_.is_valid()) {  // what follows the last boundary means nothing
      const std::string_view piece = bytes.substr(0, kAtOnce);
      bytes.remove_prefix(piece.size());
      silent_ += piece.size();
      const bool understood = parser_.parse(
          piece.data(), piece.size(), [this](const httplib::FormData& part) { return begin(part); },
          [this](const char* data, std::size_t size) {
            return append({data, size});
          });
      if (failure_) return *std::move(failure_);
      // The library keeps everything in memory until it has a part to give.
      if (!understood || silent_ > kLongestPartHead) return broken();
    }
    return {};
  }

  Result<> finish() const {
    if (!parser_.is_valid()) return Error{Cause::BadRequest, "the form ends before its last boundary"};
    return {};
  }

 private:
  static constexpr std::size_t kAtOnce = 16 << 10, kLongestPartHead = 48 << 10;

  static Error broken() {
    return {Cause::BadRequest,
            "the body breaks the rules of multipart/form-data, or its boundary is another"};
  }
  bool begin(const httplib::FormData& part) {
    silent_ = 0;
    return keep(parts_.begin(part.name, part.content_type));
  }
  bool append(std::string_view bytes) {
    silent_ = 0;
    return keep(parts_.append(bytes));
  }
  bool keep(Result<> result) {
    if (!result) failure_ = std::move(result).error();
    return !failure_;
  }

  BodyParts& parts_;
  httplib::detail::FormDataParser parser_;
  std::size_t silent_ = 0;  ///< bytes since the parser last gave anything
  std::optional<Error> failure_;
};

}  // namespace burnish
