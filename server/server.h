// The whole server in one object: both transports, the queue and the service, for main() and for tests.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "server/config.h"
#include "server/grpc/grpc_server.h"
#include "server/http/http_server.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/jobs.h"
#include "server/lifecycle.h"
#include "server/observe/metrics.h"

namespace burnish {

class Server {
 public:
  /// Opens both ports, sends a tiny mesh through the workers, then serves, then writes the ports file.
  /// `smooth` stands in for the real one in tests. Errors: BadOption when a port cannot open or the spool
  /// folder cannot be written, FileError when the ports file cannot be written, what the self-test says.
  static Result<std::unique_ptr<Server>> start(const Config& config, SmoothFunction smooth = {});
  ~Server();  ///< stop(zero)

  const Address& grpc_address() const { return grpc_->address(); }
  const Address& http_address() const { return http_->address(); }
  LifecycleState state() const { return lifecycle_.state(); }
  const JobRunner& runner() const { return runner_; }

  /// Reports not-serving, refuses new jobs, lets accepted ones finish for up to `grace`, stops the rest,
  /// sends every answer, closes the ports. Safe to repeat; a second call while the first waits shortens its
  /// grace.
  void stop(std::chrono::milliseconds grace);

 private:
  Server(const Config& config, SmoothFunction smooth);
  Result<> open(const Config& config);
  void tell_health();
  void watch(const std::stop_token& stop);

  Lifecycle lifecycle_;
  Metrics metrics_;
  SmoothService service_;
  Spool spool_;
  JobRunner runner_;
  Jobs jobs_;
  Gateway gateway_;
  std::mutex stop_mutex_;
  std::unique_ptr<GrpcServer> grpc_;
  std::unique_ptr<HttpServer> http_;
  std::mutex health_mutex_;
  bool healthy_ = false;  ///< guarded by health_mutex_
  std::jthread health_;   ///< last: it uses all of the above
};

}  // namespace burnish
