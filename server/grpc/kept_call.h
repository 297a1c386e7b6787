// What the calls of JobService and UploadService share. Both are synchronous services: they wait for the
// disk, for jobs and for slow callers, on threads of gRPC's that do nothing else.
#pragma once

#include <string>

#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include "server/grpc/call.h"
#include "server/grpc/grpc_status.h"

namespace burnish {

/// One call, counted from here on until its answer has been given.
class KeptCall {
 public:
  KeptCall(CallHome& home, grpc::ServerContext& context, const char* name)
      : home_(home), context_(context), name_(name), caller_(caller_of(context, Kind::Smooth, home.jobs)) {
    home_.calls.enter();
  }
  ~KeptCall() { home_.calls.leave(); }
  KeptCall(const KeptCall&) = delete;
  KeptCall& operator=(const KeptCall&) = delete;

  const Caller& caller() const { return caller_; }
  /// Nobody waits for an answer, or the server ends.
  bool over() const { return context_.IsCancelled() || !home_.jobs.serving(); }
  Error over_error() const {
    if (context_.IsCancelled()) return {Cause::Cancelled, "the caller went away"};
    return {Cause::ShuttingDown, "the server is shutting down"};
  }

  grpc::Status ok() const { return end("ok", grpc::Status::OK); }
  grpc::Status failed(const Error& error) const {
    return end(cause_code(error.cause), to_grpc_status(error, caller_.request_id));
  }
  template <class T>
  grpc::Status answer(const Result<T>& result, T* into) const {
    if (!result) return failed(result.error());
    *into = *result;
    return ok();
  }

 private:
  grpc::Status end(std::string_view outcome, grpc::Status status) const {
    spdlog::info("request id={}{}{} transport=grpc call={} outcome={}", caller_.request_id,
                 caller_.trace_id.empty() ? "" : " trace=", caller_.trace_id, name_, outcome);
    return status;
  }

  CallHome& home_;
  grpc::ServerContext& context_;
  const char* const name_;
  const Caller caller_;
};

}  // namespace burnish
