// A request's body from the wire to its parts. Includes the HTTP library's header: only for conversation.cpp.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/body_reader.h"
#include "server/http/form_parser.h"
#include "server/http/header_value.h"
#include "server/http/media_type.h"

namespace burnish {

/// Fed with the bytes of one body, without their chunks.
class BodyIntake {
 public:
  BodyIntake(Spool& spool, const RequestLimits& limits) : parts_(spool, limits) {}
  BodyIntake(const BodyIntake&) = delete;
  BodyIntake& operator=(const BodyIntake&) = delete;

  /// `expected`: the Content-Length, if any. Errors: UnsupportedFormat for a Content-Encoding, BadRequest for
  /// a form without boundary.
  Result<> begin(const HttpRequest& head, std::uint64_t expected) {
    auto decoder = BodyDecoder::for_encoding(head.header("Content-Encoding"));
    if (!decoder) return std::move(decoder).error();
    decoder_ = std::move(decoder).value();
    const std::string_view type = head.header("Content-Type");
    if (!is_form(type)) {
      parts_.begin_whole(expected);
      return {};
    }
    auto boundary = parameter_of(type, "boundary").value_or("");
    if (boundary.empty() || boundary.size() > kLongestBoundary) {
      return Error{Cause::BadRequest, "multipart/form-data needs a boundary of 1 to 70 characters"};
    }
    form_.emplace(std::move(boundary), parts_);
    return {};
  }

  /// Errors: those of BodyDecoder, FormParser and BodyParts.
  Result<> feed(std::string_view bytes) { return decoder_->feed(bytes, sink_); }

  /// The body is complete: puts it into the request.
  Result<> finish(HttpRequest& request) {
    if (auto whole = decoder_->finish(sink_); !whole) return whole;
    if (form_) {
      if (auto whole = form_->finish(); !whole) return whole;
    }
    return parts_.finish(request);
  }

 private:
  static constexpr std::size_t kLongestBoundary = 70;  // RFC 2046

  BodyParts parts_;
  std::unique_ptr<BodyDecoder> decoder_;
  std::optional<FormParser> form_;
  const ByteSink sink_ = [this](std::string_view bytes) {
    return form_ ? form_->feed(bytes) : parts_.append(bytes);
  };
};

}  // namespace burnish
