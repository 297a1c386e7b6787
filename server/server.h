// The whole server in one object: both transports, the queue and the service, for main() and for tests.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>

#include "server/config.h"
#include "server/grpc/grpc_server.h"
#include "server/http/http_server.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/smooth_jobs.h"
#include "server/lifecycle.h"
#include "server/observe/metrics.h"

namespace burnish {

class Server {
 public:
  /// Opens both ports, then serves, then writes the ports file. `smooth` stands in for the real one in tests.
  /// Errors: BadOption when a port cannot open, FileError when the ports file cannot be written.
  static Result<std::unique_ptr<Server>> start(const Config& config, SmoothFunction smooth = {});
  ~Server();  ///< stop(zero)

  const Address& grpc_address() const { return grpc_->address(); }
  const Address& http_address() const { return http_->address(); }
  LifecycleState state() const { return lifecycle_.state(); }
  const JobRunner& runner() const { return runner_; }

  /// Reports not-serving, refuses new jobs, lets accepted ones finish for up to `grace`, stops the rest,
  /// sends every answer, closes the ports. Safe to repeat; a second call while the first waits shortens its
  /// grace. False when HTTP clients are left that draw out the head of their request: nothing was accepted
  /// from them, but the destructor would wait for them.
  bool stop(std::chrono::milliseconds grace);

 private:
  Server(const Config& config, SmoothFunction smooth);
  Result<> open(const Config& config);

  Lifecycle lifecycle_;
  Metrics metrics_;
  SmoothService service_;
  JobRunner runner_;
  SmoothJobs jobs_;
  Gateway gateway_;
  std::mutex stop_mutex_;
  std::unique_ptr<GrpcServer> grpc_;
  std::unique_ptr<HttpServer> http_;
};

}  // namespace burnish
