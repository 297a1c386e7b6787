// The HTTP gateway as a function from request to response, so tests need no socket.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/http/cors.h"
#include "server/http/http_message.h"
#include "server/http/jobs_api.h"
#include "server/http/page.h"
#include "server/http/uploads_api.h"
#include "server/jobs/jobs.h"

namespace burnish {

struct GatewayOptions {
  std::vector<std::string> cors_origins = {};  ///< pages that may call from a browser; "*": all; empty: none
  std::span<const PageFile> page = {};         ///< what `/` shows; empty: nothing
};

/// Who takes a body, or, when there is no taker, the refusal of it.
struct BodyTaking {
  std::unique_ptr<BodyTaker> taker;
  HttpResponse refusal;
};

/// Every path of routes.h, and the page. Each answer carries Burnish-Request-Id; each request is logged once,
/// and those with meshes counted once. A HEAD is answered as its GET: the transport leaves out the body.
/// Thread-safe.
class Gateway {
 public:
  Gateway(Jobs& jobs, DurableJobs& durable_jobs, Uploads& uploads, GatewayOptions options = {});

  /// Everything that can be answered from the head alone; some of it waits for a job, see handle(). Nothing:
  /// a POST or PATCH whose body is worth reading.
  std::optional<HttpResponse> answer_head(
      const HttpRequest& request, const std::function<bool()>& client_gone = [] { return false; });

  /// Who takes the body of this request as it comes. Nothing: the spool does, then handle() answers. The
  /// request must outlive the taker.
  std::optional<BodyTaking> take_body(const HttpRequest& request);

  /// Answers any request; one with meshes waits for its job, which ends early when `client_gone` says so
  /// (asked every few milliseconds) or its timeout passes.
  HttpResponse handle(const HttpRequest& request, const std::function<bool()>& client_gone);

  /// Counts, logs and words the refusal of a request whose head is known.
  HttpResponse refuse(const HttpRequest& request, const Error& error);

  /// HTTP itself is broken: Cause::BadRequest or RequestTimeout, with this status. Counted and logged.
  HttpResponse bad_request(int status, const Error& error);

 private:
  struct Exchange;
  class Taker;
  std::optional<HttpResponse> answer_head(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse answer_page(Exchange& exchange);
  Result<HttpResponse> answer_kept(const Exchange& exchange, const std::function<bool()>& client_gone);
  std::optional<HttpResponse> refuse_early(Exchange& exchange);
  HttpResponse answer_read(const Exchange& exchange) const;
  HttpResponse not_ready(const Exchange& exchange) const;
  HttpResponse work(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse smooth(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse compare(Exchange& exchange, const std::function<bool()>& client_gone);
  HttpResponse refuse(Exchange& exchange, Error error);
  HttpResponse finish(const Exchange& exchange, HttpResponse response) const;

  Jobs& jobs_;
  JobsApi jobs_api_;
  UploadsApi uploads_api_;
  const Cors cors_;
  const std::span<const PageFile> page_;
  const std::string openapi_;
};

}  // namespace burnish
