// Errors as RFC 9457 problem+json.
#pragma once

#include <optional>

#include "core/run/error.h"
#include "server/http/http_message.h"

namespace burnish {

/// Status (unless another is given) and title by the status map; type "urn:burnish:problem:CODE", detail,
/// code, requestId, and field when one is to blame. Retry-After in whole seconds where trying again may help.
HttpResponse problem(const Error& error, std::string_view request_id, std::optional<int> status = {});

}  // namespace burnish
