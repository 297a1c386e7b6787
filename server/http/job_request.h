// From an HTTP request to a job.
#pragma once

#include <cstdint>

#include "server/http/http_message.h"
#include "server/http/smooth_query.h"
#include "server/jobs/durable_jobs.h"
#include "server/service/smooth_service.h"

namespace burnish {

/// A job whose views point into its request.
template <class Job>
struct JobRequest {
  Job job = {};
  Timeout timeout = {};
};

/// What a head tells of a request whose body is still to come.
struct ExpectedJob {
  std::uint64_t mesh_bytes = 0, reference_bytes = 0;  ///< 0: not known
  Timeout timeout = {};
};

/// A raw body with options in the query, or a form with the parts mesh, reference and options; a form that
/// has options takes none from the query. Errors: UnsupportedFormat; BadOption, UnknownOption, UnknownMethod,
/// naming the option or the part; TooLarge.
Result<JobRequest<SmoothJob>> read_smooth(const HttpRequest& request, const SmoothService& service);
/// The same by the head alone; also NotAcceptable for an Accept header that takes nothing of what there is.
Result<ExpectedJob> expect_smooth(const HttpRequest& head, const SmoothService& service);

/// A form with the parts reference and mesh. Errors: as read_smooth().
Result<JobRequest<CompareJob>> read_compare(const HttpRequest& request);
Result<ExpectedJob> expect_compare(const HttpRequest& head, const RequestLimits& limits);

/// A job to keep: as read_smooth(), or with meshes that are named by their SHA-256, and a priority. The same
/// errors.
Result<Submission> read_submission(const HttpRequest& request, const SmoothService& service);
Result<> expect_submission(const HttpRequest& head, const SmoothService& service);

}  // namespace burnish
