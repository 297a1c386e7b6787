#include "server/server.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <thread>
#include <utility>

#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

namespace burnish {
namespace {

/// For answers that are still being sent after the jobs are done; over HTTP no longer than the grace period,
/// because there nobody can tell them from a request that never comes whole.
constexpr std::chrono::milliseconds kLastAnswers{30'000}, kLeastPatience{2000};
constexpr std::size_t kMostHttpSmoothCalls = 256;  // each holds a thread

Limits limits_of(const Config& config) {
  Limits limits;
  limits.max_bytes = config.max_bytes;
  return limits;
}

/// Requests that can be in the server at once, a few more than have a place, so that those hear that it is
/// full.
std::size_t calls_at_once(const Config& config) {
  const unsigned workers =
      config.workers ? config.workers : std::max(1u, std::thread::hardware_concurrency());
  return workers + config.queue + 32;
}

/// Whoever waits for the file must never read half of it.
Result<> write_ports_file(const std::string& path, const Address& grpc, const Address& http) {
  const std::string partial = path + ".partial";
  {
    std::ofstream file(partial, std::ios::trunc);
    file << nlohmann::ordered_json{{"grpc", grpc.text()}, {"http", http.text()}}.dump() << "\n";
    if (!file.flush()) return Error{Cause::FileError, "cannot write the ports file " + partial};
  }
  std::error_code failure;
  std::filesystem::rename(partial, path, failure);
  if (failure)
    return Error{Cause::FileError, "cannot write the ports file " + path + ": " + failure.message()};
  return {};
}

}  // namespace

Server::Server(const Config& config, SmoothFunction smooth)
    : service_(limits_of(config)),
      runner_({.workers = config.workers, .queue = config.queue, .threads = config.threads}),
      jobs_(service_, runner_, lifecycle_, metrics_, config.longest_run, std::move(smooth)),
      gateway_(jobs_) {}

Result<std::unique_ptr<Server>> Server::start(const Config& config, SmoothFunction smooth) {
  auto server = std::unique_ptr<Server>(new Server(config, std::move(smooth)));
  if (auto opened = server->open(config); !opened) return std::move(opened).error();
  return server;
}

Result<> Server::open(const Config& config) {
  const std::size_t calls = calls_at_once(config);
  auto http = HttpServer::start({.listen = config.http_listen,
                                 .max_bytes = config.max_bytes,
                                 .smooth_calls = std::min(calls, kMostHttpSmoothCalls)},
                                gateway_);
  if (!http) return std::move(http).error();
  http_ = std::move(http).value();
  auto grpc = GrpcServer::start(
      {.listen = config.grpc_listen, .max_bytes = config.max_bytes, .max_streams = static_cast<int>(calls)},
      jobs_);
  if (!grpc) return std::move(grpc).error();
  grpc_ = std::move(grpc).value();

  lifecycle_.move_to(LifecycleState::Serving);
  grpc_->set_serving(true);
  spdlog::info("serving gRPC on {} and HTTP on {}", grpc_address().text(), http_address().text());
  if (config.ports_file.empty()) return {};
  return write_ports_file(config.ports_file, grpc_address(), http_address());
}

Server::~Server() { stop(std::chrono::milliseconds::zero()); }

bool Server::stop(std::chrono::milliseconds grace) {
  const bool served = lifecycle_.serving();
  if (lifecycle_.move_to(LifecycleState::Draining) && served) {
    spdlog::info("draining: {} jobs run, {} wait", runner_.running(), runner_.queued());
    grpc_->set_serving(false);
  }
  runner_.drain(grace);
  const std::lock_guard stopping(stop_mutex_);
  const bool http_ended = !http_ || http_->stop(std::clamp(grace, kLeastPatience, kLastAnswers));
  if (grpc_) grpc_->stop(kLastAnswers);
  if (lifecycle_.move_to(LifecycleState::Stopped) && served) spdlog::info("stopped");
  return http_ended;
}

}  // namespace burnish
