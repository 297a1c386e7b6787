// The gRPC side: SmoothingService, health and reflection on one port.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include <grpcpp/grpcpp.h>

#include "server/config.h"
#include "server/grpc/smoothing_handler.h"

namespace burnish {

struct GrpcServerOptions {
  Address listen;
  std::uint64_t max_bytes = 0;  ///< of a mesh and of a reference, each
  int max_streams = 128;        ///< calls at once on one connection
};

class GrpcServer {
 public:
  /// Opens the port and answers calls; health says not serving until told otherwise.
  /// Errors: BadOption when the port cannot open.
  static Result<std::unique_ptr<GrpcServer>> start(const GrpcServerOptions& options, SmoothJobs& jobs);
  ~GrpcServer();  ///< stop(zero)

  const Address& address() const { return address_; }  ///< with the port that was opened

  /// What the health service says, for "" and for burnish.v1.SmoothingService.
  void set_serving(bool serving);

  /// Waits until every answer to Smooth has been sent, for at most `patience`, then closes all connections.
  /// Jobs must have been drained. Safe to repeat.
  void stop(std::chrono::milliseconds patience);

 private:
  explicit GrpcServer(SmoothJobs& jobs) : handler_(jobs) {}

  SmoothingHandler handler_;
  Address address_;
  std::unique_ptr<grpc::Server> server_;  ///< last: it calls the handler
};

}  // namespace burnish
