#include "server/http/uploads_api.h"

#include <charconv>
#include <optional>
#include <utility>

#include <absl/strings/escaping.h>
#include <spdlog/spdlog.h>

#include "server/http/header_value.h"
#include "server/http/media_type.h"

namespace burnish {
namespace {

constexpr std::string_view kPartialType = "application/partial-upload";

HttpResponse answer(int status, const v1::Upload& upload) {
  HttpResponse response{.status = status,
                        .headers = {{"Content-Type", std::string(kJsonType)},
                                    {"Cache-Control", "no-store"},
                                    {"Location", "/v1/uploads/" + upload.id()},
                                    {"Upload-Offset", std::to_string(upload.offset())},
                                    {"Upload-Complete", upload.complete() ? "?1" : "?0"}},
                        .body = to_json(upload, true) + "\n"};
  if (upload.bytes() > 0) response.headers["Upload-Length"] = std::to_string(upload.bytes());
  return response;
}

Error bad_header(const std::string& name, std::string_view text, const std::string& expected) {
  return {Cause::BadRequest, name + " is '" + std::string(text) + "', expected " + expected, name};
}

/// Nothing: the header is not there.
Result<std::optional<std::uint64_t>> number_of(const HttpRequest& request, const std::string& name) {
  const std::string_view text = request.header(name);
  if (text.empty()) return std::optional<std::uint64_t>();
  std::uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.begin(), text.end(), value);
  if (failure != std::errc() || end != text.end()) return bad_header(name, text, "a number of bytes");
  return std::optional(value);
}

Result<std::optional<bool>> complete_of(const HttpRequest& request) {
  const std::string_view text = request.header("Upload-Complete");
  if (text.empty()) return std::optional<bool>();
  if (text != "?0" && text != "?1") return bad_header("Upload-Complete", text, "?0 or ?1");
  return std::optional(text == "?1");
}

/// In hexadecimal digits; empty: the header tells of no SHA-256.
Result<std::string> digest_of(const HttpRequest& request) {
  const std::string_view text = request.header("Repr-Digest");
  for (const std::string_view item : split_value(text, ',')) {
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos || !same_ignoring_case(item.substr(0, equals), "sha-256")) continue;
    const std::string_view value = item.substr(equals + 1);
    std::string bytes;
    const bool fine = value.size() > 2 && value.front() == ':' && value.back() == ':' &&
                      absl::Base64Unescape(std::string(value.substr(1, value.size() - 2)), &bytes) &&
                      bytes.size() == 32;
    if (!fine) return bad_header("Repr-Digest", text, "sha-256=:BASE64:");
    return absl::BytesToHexString(bytes);
  }
  return std::string();
}

class Taker final : public BodyTaker {
 public:
  ~Taker() override {
    if (finished_ || status_ != 201) return;
    // Nobody has heard of this upload.
    append_.reset();
    if (auto gone = uploads_.remove(caller_, upload_.id()); !gone && gone.error().cause != Cause::NotFound)
      spdlog::warn("upload id={}: {}", upload_.id(), gone.error().message);
  }

  /// `append` null: the upload is complete already, and whatever comes is not needed.
  Taker(Uploads& uploads, Caller caller, v1::Upload upload, std::unique_ptr<Uploads::Append> append,
        std::optional<bool> complete, int status)
      : uploads_(uploads),
        caller_(std::move(caller)),
        upload_(std::move(upload)),
        append_(std::move(append)),
        complete_(complete),
        status_(status) {}

  Result<> take(std::string_view bytes) override {
    came_ = came_ || !bytes.empty();
    return append_ ? append_->write(bytes) : Result<>();
  }

  Result<HttpResponse> finish() override {
    if (!append_) {
      finished_ = true;
      return answer(status_, upload_);
    }
    // Without a word on it, a first request with bytes brings all of them.
    const bool last = complete_.value_or(status_ == 201 && came_ && upload_.bytes() == 0);
    auto upload = append_->finish(last);
    if (!upload) return std::move(upload).error();
    finished_ = true;
    return answer(status_, *upload);
  }

 private:
  Uploads& uploads_;
  const Caller caller_;
  const v1::Upload upload_;
  std::unique_ptr<Uploads::Append> append_;
  const std::optional<bool> complete_;
  const int status_;
  bool came_ = false, finished_ = false;
};

}  // namespace

Result<std::unique_ptr<BodyTaker>> UploadsApi::create(const HttpRequest& request, const Caller& caller) {
  const auto length = number_of(request, "Upload-Length");
  if (!length) return length.error();
  const auto complete = complete_of(request);
  if (!complete) return complete.error();
  const auto digest = digest_of(request);
  if (!digest) return digest.error();
  auto upload = uploads_.create(caller, length->value_or(0), *digest);
  if (!upload) return std::move(upload).error();
  std::unique_ptr<Uploads::Append> append;
  if (!upload->complete()) {
    auto opened = uploads_.append(caller, upload->id(), 0);
    if (!opened) return std::move(opened).error();
    append = std::move(opened).value();
  }
  return std::unique_ptr<BodyTaker>(std::make_unique<Taker>(uploads_, caller, std::move(upload).value(),
                                                            std::move(append), *complete, 201));
}

Result<std::unique_ptr<BodyTaker>> UploadsApi::append(const HttpRequest& request, const Caller& caller,
                                                      const std::string& id) {
  const auto upload = uploads_.get(caller, id);
  if (!upload) return upload.error();
  if (media_type(request.header("Content-Type")) != kPartialType)
    return Error{Cause::UnsupportedFormat, "PATCH takes Content-Type: " + std::string(kPartialType)};
  const auto offset = number_of(request, "Upload-Offset");
  if (!offset) return offset.error();
  if (!*offset) return Error{Cause::BadRequest, "PATCH needs the header Upload-Offset", "Upload-Offset"};
  const auto complete = complete_of(request);
  if (!complete) return complete.error();
  auto append = uploads_.append(caller, id, **offset);
  if (!append) return std::move(append).error();
  return std::unique_ptr<BodyTaker>(std::make_unique<Taker>(
      uploads_, caller, *upload, std::move(append).value(), complete->value_or(false), 200));
}

Result<HttpResponse> UploadsApi::get(const Caller& caller, const std::string& id) {
  const auto upload = uploads_.get(caller, id);
  if (!upload) return upload.error();
  return answer(200, *upload);
}

Result<HttpResponse> UploadsApi::remove(const Caller& caller, const std::string& id) {
  if (auto removed = uploads_.remove(caller, id); !removed) return std::move(removed).error();
  return HttpResponse{.status = 204};
}

std::string UploadsApi::offset_of(const Caller& caller, const std::string& id) {
  const auto upload = uploads_.get(caller, id);
  return upload ? std::to_string(upload->offset()) : "";
}

}  // namespace burnish
