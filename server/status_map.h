// The one table from cause to what each transport says.
#pragma once

#include <string>

#include "core/run/error.h"

namespace burnish {

struct StatusRow {
  Cause cause;
  int grpc_code;  ///< grpc::StatusCode by number; this header knows no transport
  int http_status;
  int exit_code;      ///< of the command line: 2 bad call, 3 bad mesh, 4 refused or out of time, 5 server, 6
                      ///< files
  const char* title;  ///< problem+json's title: the same for every occurrence
};

/// A row for every cause.
const StatusRow& status_of(Cause cause);

/// Whether a server can answer so; the other causes arise at the caller's side only.
bool comes_from_servers(Cause cause);

/// The cause with this code ("queue_full", or "QUEUE_FULL"); Internal for an unknown one.
Cause cause_from_code(std::string_view code);

}  // namespace burnish
