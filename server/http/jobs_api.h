// /v1/jobs: jobs that outlive their call.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "server/http/http_message.h"
#include "server/jobs/durable_jobs.h"

namespace burnish {

/// Each is one verb of one path. Errors: those of DurableJobs; BadOption, UnknownOption for the query and the
/// headers, naming them. Thread-safe.
class JobsApi {
 public:
  explicit JobsApi(Jobs& jobs, DurableJobs& durable_jobs) : jobs_(jobs), durable_jobs_(durable_jobs) {}

  /// What can be said of a submission by its head.
  Result<> expect(const HttpRequest& head) const;
  /// 202 with the job. The mesh is the body, a part of a form, or one that is named by its SHA-256
  /// (mesh_sha256, reference_sha256: in the query, or parts).
  Result<HttpResponse> submit(const HttpRequest& request, const Caller& caller);
  Result<HttpResponse> list(const HttpRequest& request, const Caller& caller);
  /// "Prefer: wait=N" waits until the job has ended, for N seconds (at most 60), or until `client_gone`. 303
  /// to its mesh for who accepts a mesh and no JSON.
  Result<HttpResponse> get(const HttpRequest& request, const Caller& caller, const std::string& id,
                           const std::function<bool()>& client_gone);
  /// Server-sent events: the job whenever it changes, until it has ended. QueueFull when too many listen.
  Result<HttpResponse> events(const Caller& caller, const std::string& id);
  /// The smoothed mesh or a range of it.
  Result<HttpResponse> mesh(const HttpRequest& request, const Caller& caller, const std::string& id);
  Result<HttpResponse> report(const Caller& caller, const std::string& id);
  /// Cancels a job that has not ended (202), removes one that has (204).
  Result<HttpResponse> remove(const Caller& caller, const std::string& id);

 private:
  HttpResponse answer(int status, const v1::Job& job) const;

  Jobs& jobs_;
  DurableJobs& durable_jobs_;
  std::shared_ptr<std::atomic<int>> listeners_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace burnish
