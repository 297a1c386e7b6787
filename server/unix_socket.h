// The file of a Unix domain socket before a server binds it.
#pragma once

#include <string>

#include "core/run/error.h"

namespace burnish {

/// Removes what a server that died left at `path`. Errors: BadOption when somebody listens there, when the
/// file is no socket, or when it cannot be removed.
Result<> clear_unix_socket(const std::string& path);

}  // namespace burnish
