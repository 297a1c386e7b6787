// burnish.v1.SmoothingService on gRPC's callback API. Nothing here blocks: jobs run on the runner's workers.
#pragma once

#include "burnish/v1/smoothing.grpc.pb.h"
#include "server/jobs/smooth_jobs.h"

namespace burnish {

class SmoothingHandler final : public v1::SmoothingService::CallbackService {
 public:
  explicit SmoothingHandler(SmoothJobs& jobs) : jobs_(jobs) {}

  grpc::ServerUnaryReactor* Smooth(grpc::CallbackServerContext* context, const v1::SmoothRequest* request,
                                   v1::SmoothResponse* response) override;
  grpc::ServerUnaryReactor* ListMethods(grpc::CallbackServerContext* context,
                                        const v1::ListMethodsRequest* request,
                                        v1::ListMethodsResponse* response) override;

 private:
  SmoothJobs& jobs_;
};

}  // namespace burnish
