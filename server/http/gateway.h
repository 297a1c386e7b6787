// The HTTP gateway as a function from request to response, so tests need no socket.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/http/cors.h"
#include "server/http/http_message.h"
#include "server/jobs/jobs.h"

namespace burnish {

struct GatewayOptions {
  std::vector<std::string> cors_origins;  ///< pages that may call from a browser; "*": all; empty: none
};

/// Every path of routes.h. Each answer carries Burnish-Request-Id; each request is logged once, and those
/// with meshes counted once. A HEAD is answered as its GET: the transport leaves out the body. Thread-safe.
class Gateway {
 public:
  explicit Gateway(Jobs& jobs, GatewayOptions options = {});

  /// Everything that can be answered from the head alone. Nothing: a POST whose body is worth reading.
  std::optional<HttpResponse> answer_head(const HttpRequest& request);

  /// Answers any request; one with meshes waits for its job, which ends early when `client_gone` says so
  /// (asked every few milliseconds) or its timeout passes.
  HttpResponse handle(const HttpRequest& request, const std::function<bool()>& client_gone);

  /// Counts, logs and words the refusal of a request whose head is known.
  HttpResponse refuse(const HttpRequest& request, const Error& error);

  /// HTTP itself is broken: Cause::BadRequest or RequestTimeout, with this status. Counted and logged.
  HttpResponse bad_request(int status, const Error& error);

 private:
  struct Exchange;
  std::optional<HttpResponse> answer_head(Exchange& exchange);
  std::optional<HttpResponse> refuse_early(Exchange& exchange);
  HttpResponse answer_read(const Exchange& exchange) const;
  HttpResponse not_ready(const Exchange& exchange) const;
  HttpResponse work(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse smooth(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse compare(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse refuse(Exchange& exchange, Error error);
  HttpResponse finish(const Exchange& exchange, HttpResponse response) const;

  Jobs& jobs_;
  const Cors cors_;
  const std::string openapi_;
};

}  // namespace burnish
