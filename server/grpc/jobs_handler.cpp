#include "server/grpc/jobs_handler.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/grpc/kept_call.h"
#include "server/grpc/messages.h"
#include "server/jobs/latest_job.h"

namespace burnish {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kEvery{50};
constexpr int kMostWatchers = 256;  // each holds a thread
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

/// The formats, checked, from `format` and `reference_format`.
struct Formats {
  std::optional<Format> format, reference_format;
};

Result<Submission> submission_of(const v1::SubmitJobRequest& request) {
  Formats formats;
  if (auto fine = set_formats(request, formats); !fine) return std::move(fine).error();
  if (!v1::JobPriority_IsValid(request.priority()))
    return Error{Cause::BadOption, "priority is none of JobPriority", "priority"};
  for (const bool both : {!request.mesh().empty() && !request.mesh_sha256().empty(),
                          !request.reference().empty() && !request.reference_sha256().empty()}) {
    if (both) return Error{Cause::BadOption, "a mesh comes with bytes and by its SHA-256", "mesh_sha256"};
  }
  Submission submission;
  submission.mesh = {request.mesh(), request.mesh_sha256(), formats.format};
  submission.reference = {request.reference(), request.reference_sha256(), formats.reference_format};
  submission.options = request.options();
  if (request.priority() == v1::JOB_PRIORITY_LOW) submission.priority = v1::JOB_PRIORITY_LOW;
  submission.idempotency_key = request.idempotency_key();
  if (request.timeout_ms() > 0) submission.timeout = milliseconds(request.timeout_ms());
  return submission;
}

}  // namespace

grpc::Status JobsHandler::SubmitJob(grpc::ServerContext* context, const v1::SubmitJobRequest* request,
                                    v1::Job* response) {
  const KeptCall call(home_, *context, "SubmitJob");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  if (const std::size_t bytes = request->ByteSizeLong(); bytes > home_.limits.max_message_bytes) {
    return call.failed({Cause::TooLarge, "the request has " + std::to_string(bytes) +
                                             " bytes, a unary call carries " +
                                             std::to_string(home_.limits.max_message_bytes) +
                                             " (max-unary-bytes); use UploadService and mesh_sha256"});
  }
  auto submission = submission_of(*request);
  if (!submission) return call.failed(submission.error());
  return call.answer(jobs_.submit(call.caller(), std::move(submission).value()), response);
}

grpc::Status JobsHandler::GetJob(grpc::ServerContext* context, const v1::GetJobRequest* request,
                                 v1::Job* response) {
  const KeptCall call(home_, *context, "GetJob");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  return call.answer(jobs_.get(call.caller(), request->id()), response);
}

grpc::Status JobsHandler::ListJobs(grpc::ServerContext* context, const v1::ListJobsRequest* request,
                                   v1::ListJobsResponse* response) {
  const KeptCall call(home_, *context, "ListJobs");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  return call.answer(jobs_.list(call.caller(), request->page_size(), request->page_token()), response);
}

grpc::Status JobsHandler::WatchJob(grpc::ServerContext* context, const v1::WatchJobRequest* request,
                                   grpc::ServerWriter<v1::Job>* writer) {
  const KeptCall call(home_, *context, "WatchJob");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  const auto place = std::shared_ptr<void>(nullptr, [this](void*) { --watchers_; });
  if (++watchers_ > kMostWatchers) {
    return call.failed({.cause = Cause::QueueFull,
                        .message = "more than " + std::to_string(kMostWatchers) + " callers watch jobs",
                        .retry_after = std::chrono::seconds(15)});
  }
  const auto latest = LatestJob::watch(jobs_, call.caller(), request->id());
  if (!latest) return call.failed(latest.error());
  v1::Job job;
  std::uint64_t seen = 0;
  while (!call.over()) {
    if (!latest->wait(seen, kEvery, job)) continue;
    if (!writer->Write(job)) break;
    if (has_ended(job.state())) return call.ok();
    latest->pause(kEvery);
  }
  return call.failed(call.over_error());
}

grpc::Status JobsHandler::CancelJob(grpc::ServerContext* context, const v1::CancelJobRequest* request,
                                    v1::Job* response) {
  const KeptCall call(home_, *context, "CancelJob");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  return call.answer(jobs_.cancel(call.caller(), request->id()), response);
}

grpc::Status JobsHandler::DeleteJob(grpc::ServerContext* context, const v1::DeleteJobRequest* request,
                                    v1::DeleteJobResponse*) {
  const KeptCall call(home_, *context, "DeleteJob");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  const auto removed = jobs_.remove(call.caller(), request->id());
  return removed ? call.ok() : call.failed(removed.error());
}

grpc::Status JobsHandler::DownloadResult(grpc::ServerContext* context,
                                         const v1::DownloadResultRequest* request,
                                         grpc::ServerWriter<v1::DownloadResultResponse>* writer) {
  const KeptCall call(home_, *context, "DownloadResult");
  if (const auto& refusal = call.caller().refusal) return call.failed(*refusal);
  const auto result = jobs_.result(call.caller(), request->id());
  if (!result) return call.failed(result.error());
  const std::string_view bytes = result->content.bytes;
  if (request->offset() > bytes.size()) {
    return call.failed({Cause::RangeNotSatisfiable,
                        "the offset is behind the last of " + std::to_string(bytes.size()) + " bytes",
                        "offset"});
  }
  v1::DownloadResultResponse part;
  *part.mutable_file() = result->file;
  bool taken = writer->Write(part);
  for (std::size_t at = request->offset(); taken && at < bytes.size(); at += kChunkBytes) {
    part.set_chunk(std::string(bytes.substr(at, kChunkBytes)));
    taken = !call.over() && writer->Write(part);
  }
  return taken ? call.ok() : call.failed(call.over_error());
}

}  // namespace burnish
