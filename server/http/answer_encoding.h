// Content-Encoding of answers.
#pragma once

#include <functional>
#include <string_view>

#include "server/http/http_message.h"

namespace burnish {

/// Compresses a body that is text and large enough to gain from it, for a client that accepts gzip. False
/// when `give_up` said so meanwhile; the response is then of no use.
bool encode_answer(HttpResponse& response, std::string_view accept_encoding,
                   const std::function<bool()>& give_up);

}  // namespace burnish
