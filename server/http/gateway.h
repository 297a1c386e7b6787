// The HTTP gateway as a function from request to response, so tests need no socket.
#pragma once

#include <functional>
#include <optional>

#include "server/http/http_message.h"
#include "server/jobs/smooth_jobs.h"

namespace burnish {

/// Routes: POST /v1/smooth, GET and HEAD of /v1/methods, /livez, /readyz, /metrics. Thread-safe.
class Gateway {
 public:
  explicit Gateway(SmoothJobs& jobs) : jobs_(jobs) {}

  /// Everything that can be answered from the head alone. Nothing: a POST /v1/smooth whose body is worth
  /// reading.
  std::optional<HttpResponse> answer_head(const HttpRequest& request);

  /// Answers any request; one to smooth waits for its job, which ends early when `client_gone` says so (asked
  /// every few milliseconds) or its timeout passes.
  HttpResponse handle(const HttpRequest& request, const std::function<bool()>& client_gone);

  /// Counts, logs and words the refusal of a request to smooth.
  HttpResponse refuse(const Error& error);

 private:
  HttpResponse answer_read(std::string_view path);
  std::optional<HttpResponse> refuse_early(const HttpRequest& request);
  HttpResponse smooth(const HttpRequest& request, const std::function<bool()>& client_gone);

  SmoothJobs& jobs_;
};

/// The body has more bytes than the limit.
Error body_too_large(std::uint64_t limit);

}  // namespace burnish
