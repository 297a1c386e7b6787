// Asks a running server whether it is ready, as an engine's HEALTHCHECK does from inside its container.
#pragma once

#include <chrono>

#include "server/config.h"

namespace burnish {

/// GET /readyz at the HTTP address of these settings, over TLS when they name a certificate: the server's own
/// is not verified, and is shown as the caller's. Errors, with the reason: Unreachable.
Result<> check_health(const Config& config, std::chrono::seconds patience = std::chrono::seconds(5));

}  // namespace burnish
