// The description of the HTTP interface for machines: OpenAPI 3.1.
#pragma once

#include <string>

#include "server/service/limits.h"

namespace burnish {

/// The document as JSON, written from what the server itself goes by: the routes, the status map, the
/// methods, the contract's messages and these limits.
std::string openapi_document(const RequestLimits& limits);

}  // namespace burnish
