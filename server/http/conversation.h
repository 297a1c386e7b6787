// HTTP/1.1 with one client: its requests, one after the other. cpp-httplib reads heads, targets and chunks
// and writes heads; time, size, bodies, compression and closing are decided here. The only part that includes
// the library, whose header takes long to compile.
#pragma once

#include <string>

#include "server/http/connection.h"
#include "server/http/gateway.h"
#include "server/jobs/spool.h"
#include "server/service/limits.h"

namespace burnish {

struct ConversationContext {
  Gateway& gateway;
  Spool& spool;
  RequestLimits limits = {};
  HttpPatience patience = {};
};

/// Answers until the client or the server ends, or until it must end because a request was not understood or
/// not read to its end. Never throws.
void converse(Connection& connection, const ConversationContext& context);

/// A response that closes its connection, as it goes over the wire.
std::string closing_answer(const HttpResponse& response);

}  // namespace burnish
