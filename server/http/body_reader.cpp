#include "server/http/body_reader.h"

#include <utility>

#include "server/http/header_value.h"
#include "server/observe/log.h"

namespace burnish {
namespace {

constexpr std::size_t kLargePiece = 64 << 10;
constexpr std::size_t kMostParts = 8;

}  // namespace

Result<std::unique_ptr<BodyDecoder>> BodyDecoder::for_encoding(std::string_view content_encoding) {
  auto decoder = std::make_unique<BodyDecoder>();
  if (content_encoding.empty() || same_ignoring_case(content_encoding, "identity")) return decoder;
  for (const std::string_view known : {"gzip", "x-gzip", "deflate"}) {
    if (!same_ignoring_case(content_encoding, known)) continue;
    decoder->inflater_.emplace();
    return decoder;
  }
  return Error{Cause::UnsupportedFormat, "Content-Encoding '" + printable(content_encoding, 50) +
                                             "' is not understood; send the body plain, gzip or deflate"};
}

Result<> BodyDecoder::feed(std::string_view bytes, const ByteSink& sink) {
  if (!inflater_) return collect(bytes, sink);
  return inflater_->feed(bytes, [&](std::string_view plain) { return collect(plain, sink); });
}

Result<> BodyDecoder::collect(std::string_view bytes, const ByteSink& sink) {
  collected_.append(bytes);
  if (collected_.size() < kLargePiece) return {};
  auto taken = sink(collected_);
  collected_.clear();
  return taken;
}

Result<> BodyDecoder::finish(const ByteSink& sink) {
  if (inflater_) {
    if (auto whole = inflater_->finish(); !whole) return whole;
  }
  return collected_.empty() ? Result<>() : sink(collected_);
}

void BodyParts::open(std::string what, std::uint64_t limit, std::string_view limit_name,
                     std::uint64_t expected) {
  body_ = spool_.body(expected);
  what_ = std::move(what);
  limit_ = limit;
  limit_name_ = limit_name;
}

void BodyParts::begin_whole(std::uint64_t expected) {
  form_ = false;
  parts_.emplace_back();
  open("the body", limits_.mesh.max_bytes, "max-bytes", expected);
}

Result<> BodyParts::begin(std::string name, std::string content_type) {
  if (auto closed = close(); !closed) return closed;
  if (parts_.size() == kMostParts) {
    return Error{Cause::BadRequest, "the form has more than " + std::to_string(kMostParts) + " parts"};
  }
  const std::string what = "the part '" + printable(name, 50) + "'";
  if (name == "options") {
    open(what, limits_.max_option_bytes, "max-option-bytes");
  } else {
    open(what, limits_.mesh.max_bytes, "max-bytes");
  }
  parts_.push_back({.name = std::move(name), .content_type = std::move(content_type), .content = {}});
  return {};
}

Result<> BodyParts::append(std::string_view bytes) {
  if (bytes.size() > limit_ - body_->size()) {
    return Error{Cause::TooLarge, what_ + " has more than " + std::to_string(limit_) +
                                      " bytes, the limit of this server (" + std::string(limit_name_) + ")"};
  }
  return body_->append(bytes);
}

Result<> BodyParts::close() {
  if (parts_.empty()) return {};
  const auto bytes = body_->finish();
  if (!bytes) return bytes.error();
  parts_.back().content = {.bytes = bytes.value(), .owner = std::move(body_)};
  return {};
}

Result<> BodyParts::finish(HttpRequest& request) {
  if (auto closed = close(); !closed) return closed;
  if (form_) {
    request.parts = std::move(parts_);
  } else {
    request.body = std::move(parts_.front().content);
  }
  return {};
}

}  // namespace burnish
