// What the head of a request says about its body and its connection.
#pragma once

#include <cstdint>
#include <optional>

#include "core/run/error.h"
#include "server/http/http_message.h"

namespace burnish {

/// How long the body is that follows a head.
struct BodyLength {
  bool chunked = false;
  std::uint64_t bytes = 0;  ///< unless chunked
};

/// Errors: BadRequest.
Result<BodyLength> body_length(const HttpRequest& request);

struct RequestHead {
  HttpRequest request;
  bool http_1_0 = false;
  bool wants_close = false;
  BodyLength length = {};
  std::optional<Error> flaw = {};  ///< nobody knows where such a request ends
};

RequestHead understand(HttpRequest request, bool http_1_0);

}  // namespace burnish
