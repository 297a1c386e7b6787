// From gRPC's status to the client's error.
#pragma once

#include "client/result.h"

namespace burnish::client {

/// Cause, field and retry_after from the status details of burnishd; the cause by the code alone for a status
/// that has none.
Error error_from(const grpc::Status& status);

}  // namespace burnish::client
