// The gRPC side: SmoothingService, health and reflection on one address.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include <grpcpp/grpcpp.h>

#include "server/config.h"
#include "server/grpc/smoothing_handler.h"

namespace burnish {

class GrpcServer {
 public:
  /// Opens the address and answers calls; health says not serving until told otherwise. A Unix domain socket
  /// that a dead server left is replaced. `idle`: CallLimits::idle. Errors: BadOption when the address cannot
  /// be opened.
  static Result<std::unique_ptr<GrpcServer>> start(const Config& config, Jobs& jobs,
                                                   std::chrono::milliseconds idle = CallLimits().idle);
  ~GrpcServer();  ///< stop(zero)

  const Address& address() const { return address_; }  ///< with the port that was opened

  /// What the health service says, for "" and for burnish.v1.SmoothingService.
  void set_serving(bool serving);

  /// Answers ShuttingDown to every call whose bytes have not all come. Streams that start later are refused
  /// by the lifecycle, which must have left Serving.
  void refuse_uploads();

  /// refuse_uploads(), then waits until every answer has been sent, for at most `patience`, then closes all
  /// connections. Jobs must have been drained. Safe to repeat.
  void stop(std::chrono::milliseconds patience);

 private:
  GrpcServer(Jobs& jobs, const CallLimits& limits) : handler_(jobs, limits) {}

  SmoothingHandler handler_;
  Address address_;
  std::unique_ptr<grpc::Server> server_;  ///< last: it calls the handler
};

}  // namespace burnish
