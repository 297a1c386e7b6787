#include "server/server.h"

#include <malloc.h>

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <thread>
#include <utility>

#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "server/observe/memory_limit.h"
#include "server/store/sqlite_records.h"

namespace burnish {
namespace {

/// For answers that are still being sent after the jobs are done; over HTTP no longer than the grace period,
/// because there nobody can tell them from a request that never comes whole.
constexpr std::chrono::milliseconds kLastAnswers{30'000}, kLeastPatience{2000};
constexpr std::chrono::seconds kHealthTick{1}, kSweepEvery{10};
constexpr int kTrims =
    10;  // ticks after the last job in which memory goes back: answers are still being sent

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

/// Whoever finds the port could use it.
Result<> check_guard(const Config& config) {
  if (!config.tokens_file.empty() || config.insecure) return {};
  for (const auto& [name, address] :
       {std::pair("grpc-listen", config.grpc_listen), std::pair("http-listen", config.http_listen)}) {
    if (address.is_local()) continue;
    return Error{Cause::BadOption,
                 std::string(name) + " " + address.text() +
                     " can be reached from other machines: say who may call (tokens), or that "
                     "everybody may (insecure)"};
  }
  return {};
}

std::uint64_t memory_for_jobs(const Config& config) {
  return config.max_memory ? config.max_memory : usable_memory() / 2;
}

/// A helper for each worker. What admission estimates may be wrong, so a helper may have twice the bound of
/// all jobs.
Result<std::unique_ptr<Sandbox>> start_sandbox(const Config& config) {
  auto started = Sandbox::start(
      {.program = config.helper_program,
       .limits = config.limits,
       .helpers = config.workers ? config.workers : std::max(1U, std::thread::hardware_concurrency()),
       .max_memory = 2 * memory_for_jobs(config)});
  if (started) return started;
  return Error{Cause::BadOption, started.error().message + " (--sandbox=false does without)"};
}

SmoothFunction smoother(Sandbox* sandbox, SmoothFunction given) {
  if (given || !sandbox) return given;
  return [sandbox](const SmoothJob& job, const RunControl& run) { return sandbox->smooth(job, run); };
}

CompareFunction comparer(Sandbox* sandbox) {
  if (!sandbox) return {};
  return [sandbox](const CompareJob& job, const RunControl& run) { return sandbox->compare(job, run); };
}

}  // namespace

Server::Server(const Config& config, Store store, std::unique_ptr<Tokens> tokens,
               std::unique_ptr<Sandbox> sandbox, SmoothFunction smooth)
    : tokens_(std::move(tokens)),
      sandbox_(std::move(sandbox)),
      service_(config.limits),
      spool_({.folder = config.spool_folder, .max_bytes = config.max_spool_bytes}),
      runner_({.workers = config.workers,
               .queue = config.queue,
               .queue_seconds = config.queue_seconds,
               .threads = config.threads,
               .max_memory = memory_for_jobs(config),
               .longest_run = config.longest_run}),
      store_(std::move(store)),
      jobs_(service_, runner_, spool_, lifecycle_, metrics_, smoother(sandbox_.get(), std::move(smooth)),
            comparer(sandbox_.get())),
      durable_jobs_(*store_.records, *store_.files, jobs_,
                    {.max_jobs = config.max_jobs, .max_seconds = config.jobs_seconds, .keep = config.keep}),
      uploads_(*store_.records, *store_.files, jobs_, {.keep = config.keep}),
      gateway_(jobs_, durable_jobs_, uploads_, {.cors_origins = config.cors_origins, .page = config.page}) {
  jobs_.ask_for(tokens_.get());
  jobs_.name_replica(config.replica);
  jobs_.set_more_gauges([this](Gauges& gauges) {
    gauges.kept_waiting = durable_jobs_.waiting();
    gauges.kept_running = durable_jobs_.running();
    gauges.cache_hits = durable_jobs_.cache_hits();
    gauges.cache_misses = durable_jobs_.cache_misses();
    gauges.store_bytes = store_.files->bytes();
    if (!sandbox_) return;
    gauges.helper_bytes = sandbox_->resident_bytes();
    gauges.ended_helpers = sandbox_->ended_helpers();
  });
}

Result<std::unique_ptr<Server>> Server::start(const Config& config, SmoothFunction smooth) {
  if (auto guarded = check_guard(config); !guarded) return std::move(guarded).error();
  std::unique_ptr<Tokens> tokens;
  if (!config.tokens_file.empty()) {
    auto loaded = Tokens::load(config.tokens_file);
    if (!loaded) return std::move(loaded).error();
    tokens = std::move(loaded).value();
  }
  std::unique_ptr<TlsContexts> tls;
  if (config.tls.given()) {
    auto loaded = TlsContexts::load(config.tls);
    if (!loaded) return std::move(loaded).error();
    tls = std::move(loaded).value();
  }
  std::unique_ptr<Sandbox> sandbox;
  if (config.sandbox && !config.helper_program.empty()) {
    auto started = start_sandbox(config);
    if (!started) return std::move(started).error();
    sandbox = std::move(started).value();
  }
  auto store = open_store(config);
  if (!store) return std::move(store).error();
  auto server = std::unique_ptr<Server>(
      new Server(config, std::move(store).value(), std::move(tokens), std::move(sandbox), std::move(smooth)));
  server->tls_ = std::move(tls);
  if (auto opened = server->open(config); !opened) return std::move(opened).error();
  return server;
}

Result<Server::Store> Server::open_store(const Config& config) {
  Store store;
  std::string folder = config.store_folder;
  if (folder.empty()) {
    std::error_code failure;
    folder = (std::filesystem::temp_directory_path(failure) / "burnish-store-XXXXXX").string();
    if (!::mkdtemp(folder.data()))
      return Error{Cause::BadOption, "cannot make a temporary folder for the store " + folder};
    store.temporary = folder;
  }
  auto files = FileStore::open({.folder = folder, .max_bytes = config.max_store_bytes});
  if (!files) return std::move(files).error();
  store.files = std::move(files).value();
  auto records = open_sqlite_records(folder + "/records.sqlite");
  if (!records) return std::move(records).error();
  store.records = std::move(records).value();
  return store;
}

Result<> Server::open(const Config& config) {
  if (auto usable = spool_.check(); !usable) return usable;
  HttpServerOptions http_settings = http_options(config);
  http_settings.tls = tls_.get();
  auto http = HttpServer::start(http_settings, gateway_, jobs_);
  if (!http) return std::move(http).error();
  http_ = std::move(http).value();
  auto grpc = GrpcServer::start(config, jobs_, durable_jobs_, uploads_);
  if (!grpc) return std::move(grpc).error();
  grpc_ = std::move(grpc).value();
  if (auto passed = jobs_.self_test(); !passed) return passed;
  if (auto resumed = uploads_.start(); !resumed) return resumed;

  lifecycle_.move_to(LifecycleState::Serving);
  tell_health();
  health_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
  housekeeper_ = std::jthread([this](const std::stop_token& stop) { keep_house(stop); });
  if (auto resumed = durable_jobs_.start(); !resumed) return resumed;
  spdlog::info("serving gRPC on {} and HTTP on {}", grpc_address().text(), http_address().text());
  if (config.ports_file.empty()) return {};
  return write_ports_file(config.ports_file, grpc_address(), http_address());
}

/// gRPC's health service must be told; /readyz asks by itself.
void Server::tell_health() {
  const std::lock_guard lock(health_mutex_);
  const bool serves = jobs_.serving();
  if (healthy_ && !serves && lifecycle_.serving()) spdlog::error("not ready: the workers are stuck");
  healthy_ = serves;
  grpc_->set_serving(serves);
}

void Server::watch(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  std::uint64_t ended = 0;
  int trims = 0;
  while (!stopped.wait_for(lock, stop, kHealthTick, [&stop] { return stop.stop_requested(); })) {
    tell_health();
    if (tokens_) tokens_->reload_if_changed();
    if (tls_) tls_->reload_if_changed();
    if (const auto now = runner_.ended(); now != ended) {
      ended = now;
      trims = 0;
    }
    if (trims < kTrims && runner_.queued() + runner_.running() == 0) {
      ++trims;
      ::malloc_trim(0);  // glibc keeps what jobs freed: hundreds of megabytes after a large mesh
    }
  }
}

void Server::keep_house(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  while (!stopped.wait_for(lock, stop, kSweepEvery, [&stop] { return stop.stop_requested(); })) {
    uploads_.sweep();
    if (auto swept = durable_jobs_.sweep(); !swept) spdlog::error("store: {}", swept.error().message);
  }
}

Server::~Server() {
  stop(std::chrono::milliseconds::zero());
  if (store_.temporary.empty()) return;
  std::error_code failure;
  std::filesystem::remove_all(store_.temporary, failure);
}

void Server::stop(std::chrono::milliseconds grace) {
  const bool served = lifecycle_.serving();
  if (lifecycle_.move_to(LifecycleState::Draining) && served) {
    spdlog::info("draining: {} jobs run, {} wait", runner_.running(), runner_.queued());
    tell_health();
    grpc_->refuse_uploads();
  }
  durable_jobs_.stop();
  runner_.drain(grace);
  const std::lock_guard stopping(stop_mutex_);
  health_ = {};
  housekeeper_ = {};
  if (http_) http_->stop(std::clamp(grace, kLeastPatience, kLastAnswers));
  if (grpc_) grpc_->stop(kLastAnswers);
  if (lifecycle_.move_to(LifecycleState::Stopped) && served) spdlog::info("stopped");
}

}  // namespace burnish
