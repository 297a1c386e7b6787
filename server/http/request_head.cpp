#include "server/http/request_head.h"

#include <charconv>
#include <utility>

#include "server/http/header_value.h"

namespace burnish {

Result<BodyLength> body_length(const HttpRequest& request) {
  const std::string_view coding = request.header("Transfer-Encoding");
  if (!coding.empty() && !same_ignoring_case(coding, "chunked")) {
    return Error{Cause::BadRequest, "the only Transfer-Encoding that is understood is chunked"};
  }
  BodyLength length{.chunked = !coding.empty()};
  if (length.chunked || !request.headers.contains("Content-Length")) return length;
  const std::string_view digits = request.header("Content-Length");
  const char* const end = digits.data() + digits.size();
  const auto [stop, failure] = std::from_chars(digits.data(), end, length.bytes);
  if (failure != std::errc() || stop != end) {
    return Error{Cause::BadRequest, "Content-Length is not a number of bytes"};
  }
  return length;
}

RequestHead understand(HttpRequest request, bool http_1_0) {
  RequestHead head{.request = std::move(request), .http_1_0 = http_1_0};
  const std::string_view connection = head.request.header("Connection");
  head.wants_close = value_names(connection, "close") || (http_1_0 && !value_names(connection, "keep-alive"));
  auto length = body_length(head.request);
  if (length) {
    head.length = *length;
  } else {
    head.flaw = std::move(length).error();
  }
  return head;
}

}  // namespace burnish
