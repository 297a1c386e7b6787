// Errors as RFC 9457 problem+json.
#pragma once

#include "core/run/error.h"
#include "server/http/http_message.h"

namespace burnish {

/// Status and title by the status map; type "urn:burnish:problem:CODE", detail, code, request_id, and field
/// when one is to blame. Retry-After where trying again may help.
HttpResponse problem(const Error& error, std::string_view request_id);

/// What breaks HTTP itself, before there is a request to speak of: code "bad_request", with this status.
HttpResponse bad_request(int status, std::string_view request_id);

}  // namespace burnish
