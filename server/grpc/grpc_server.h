// The gRPC side: SmoothingService, JobService, UploadService, health and reflection on one address.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include <grpcpp/grpcpp.h>

#include "server/config.h"
#include "server/grpc/jobs_handler.h"
#include "server/grpc/smoothing_handler.h"
#include "server/grpc/unary.h"
#include "server/grpc/uploads_handler.h"

namespace burnish {

class GrpcServer {
 public:
  /// Opens the address and answers calls; health says not serving until told otherwise. A Unix domain socket
  /// that a dead server left is replaced. `idle`: CallLimits::idle. Errors: BadOption when the address cannot
  /// be opened.
  static Result<std::unique_ptr<GrpcServer>> start(const Config& config, Jobs& jobs,
                                                   DurableJobs& durable_jobs, Uploads& uploads,
                                                   std::chrono::milliseconds idle = CallLimits().idle);
  ~GrpcServer();  ///< stop(zero)

  const Address& address() const { return address_; }  ///< with the port that was opened

  int calls() const { return handler_.calls().count(); }  ///< that are under way

  /// What the health service says, for "" and for each service of burnish.v1.
  void set_serving(bool serving);

  /// Answers ShuttingDown to every call whose bytes have not all come. Streams that start later are refused
  /// by the lifecycle, which must have left Serving.
  void refuse_uploads();

  /// refuse_uploads(), then waits until every answer has been sent, for at most `patience`, then closes all
  /// connections. Jobs must have been drained. Safe to repeat.
  void stop(std::chrono::milliseconds patience);

 private:
  GrpcServer(Jobs& jobs, DurableJobs& durable_jobs, Uploads& uploads, const CallLimits& limits)
      : handler_(jobs, limits),
        unary_calls_(handler_.home()),
        jobs_handler_(handler_.home(), durable_jobs),
        uploads_handler_(handler_.home(), uploads) {}

  SmoothingHandler handler_;
  UnaryCalls unary_calls_;
  JobsHandler jobs_handler_;
  UploadsHandler uploads_handler_;
  Address address_;
  std::unique_ptr<grpc::Server> server_;  ///< last: it calls the handlers
};

}  // namespace burnish
