// Errors as gRPC statuses with details.
#pragma once

#include <string_view>

#include <grpcpp/support/status.h>

#include "core/run/error.h"

namespace burnish {

/// Code and message by the status map; details: ErrorInfo (reason: the cause's code in upper case, domain
/// "burnish", metadata request_id), BadRequest when a field is to blame, RetryInfo when trying again may
/// help.
grpc::Status to_grpc_status(const Error& error, std::string_view request_id);

}  // namespace burnish
