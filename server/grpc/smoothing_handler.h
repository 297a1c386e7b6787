// burnish.v1.SmoothingService on gRPC's callback API. Nothing here blocks: jobs run on the runner's workers.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "server/jobs/jobs.h"

namespace burnish {

/// How many calls are under way, from their arrival until their answer has been sent. Thread-safe.
class CallCount {
 public:
  void enter();
  void leave();
  /// False when calls are still under way after `patience`.
  bool wait_until_none(std::chrono::milliseconds patience);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int calls_ = 0;  ///< guarded by mutex_
};

class SmoothingHandler final : public v1::SmoothingService::CallbackService {
 public:
  explicit SmoothingHandler(SmoothJobs& jobs) : jobs_(jobs) {}

  grpc::ServerUnaryReactor* Smooth(grpc::CallbackServerContext* context, const v1::SmoothRequest* request,
                                   v1::SmoothResponse* response) override;
  grpc::ServerUnaryReactor* ListMethods(grpc::CallbackServerContext* context,
                                        const v1::ListMethodsRequest* request,
                                        v1::ListMethodsResponse* response) override;

  CallCount& calls() { return calls_; }

 private:
  SmoothJobs& jobs_;
  CallCount calls_;
};

}  // namespace burnish
