// The whole server in one object: both transports, the queue and the service, for main() and for tests.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "server/config.h"
#include "server/grpc/grpc_server.h"
#include "server/http/http_server.h"
#include "server/jobs/durable_jobs.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/jobs.h"
#include "server/jobs/uploads.h"
#include "server/lifecycle.h"
#include "server/observe/metrics.h"
#include "server/sandbox/sandbox.h"
#include "server/security/tokens.h"

namespace burnish {

class Server {
 public:
  /// Opens the store and both ports, sends a tiny mesh through the workers, then serves and takes up the jobs
  /// that a former server left, then writes the ports file.
  /// `smooth` stands in for the real one in tests. Errors: BadOption when a port or the store cannot open or
  /// the spool folder cannot be written, FileError when the ports file cannot be written, what the self-test
  /// says.
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
  /// What outlives servers.
  struct Store {
    std::string temporary;  ///< the folder, when it goes with the server
    std::unique_ptr<FileStore> files;
    std::unique_ptr<Records> records;
  };
  static Result<Store> open_store(const Config& config);
  Server(const Config& config, Store store, std::unique_ptr<Tokens> tokens, std::unique_ptr<Sandbox> sandbox,
         SmoothFunction smooth);
  Result<> open(const Config& config);
  void tell_health();
  void watch(const std::stop_token& stop);
  void keep_house(const std::stop_token& stop);

  const std::unique_ptr<Tokens> tokens_;    ///< null: whoever reaches the ports may call
  const std::unique_ptr<Sandbox> sandbox_;  ///< null: jobs run in this process
  std::unique_ptr<TlsContexts> tls_;        ///< null: the ports are not encrypted
  Lifecycle lifecycle_;
  Metrics metrics_;
  SmoothService service_;
  Spool spool_;
  JobRunner runner_;
  Store store_;
  Jobs jobs_;
  DurableJobs durable_jobs_;
  Uploads uploads_;
  Gateway gateway_;
  std::mutex stop_mutex_;
  std::unique_ptr<GrpcServer> grpc_;
  std::unique_ptr<HttpServer> http_;
  std::mutex health_mutex_;
  bool healthy_ = false;               ///< guarded by health_mutex_
  std::jthread health_, housekeeper_;  ///< last: they use all of the above
};

}  // namespace burnish
