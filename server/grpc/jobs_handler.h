// burnish.v1.JobService.
#pragma once

#include <atomic>

#include "burnish/v1/jobs.grpc.pb.h"
#include "server/grpc/call.h"
#include "server/jobs/durable_jobs.h"

namespace burnish {

class JobsHandler final : public v1::JobService::Service {
 public:
  JobsHandler(CallHome& home, DurableJobs& jobs) : home_(home), jobs_(jobs) {}

  grpc::Status SubmitJob(grpc::ServerContext* context, const v1::SubmitJobRequest* request,
                         v1::Job* response) override;
  grpc::Status GetJob(grpc::ServerContext* context, const v1::GetJobRequest* request,
                      v1::Job* response) override;
  grpc::Status ListJobs(grpc::ServerContext* context, const v1::ListJobsRequest* request,
                        v1::ListJobsResponse* response) override;
  grpc::Status WatchJob(grpc::ServerContext* context, const v1::WatchJobRequest* request,
                        grpc::ServerWriter<v1::Job>* writer) override;
  grpc::Status CancelJob(grpc::ServerContext* context, const v1::CancelJobRequest* request,
                         v1::Job* response) override;
  grpc::Status DeleteJob(grpc::ServerContext* context, const v1::DeleteJobRequest* request,
                         v1::DeleteJobResponse* response) override;
  grpc::Status DownloadResult(grpc::ServerContext* context, const v1::DownloadResultRequest* request,
                              grpc::ServerWriter<v1::DownloadResultResponse>* writer) override;

 private:
  CallHome& home_;
  DurableJobs& jobs_;
  std::atomic<int> watchers_ = 0;
};

}  // namespace burnish
