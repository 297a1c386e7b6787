// The jobs with everything behind them, as Server wires them up, and no transport.
#pragma once

#include <chrono>
#include <stdexcept>
#include <utility>

#include "server/jobs/durable_jobs.h"
#include "server/jobs/jobs.h"
#include "server/jobs/uploads.h"
#include "tests/server/store_house.h"

namespace burnish::testing {

struct JobsSetting {
  RequestLimits limits = {};
  JobRunnerOptions runner = {.workers = 1};
  SmoothFunction smooth = {};
  DurableJobsOptions durable = {};
  std::string store = {};  ///< folder; empty: one of its own
};

struct JobsHouse {
  explicit JobsHouse(JobsSetting setting = {})
      : service(setting.limits),
        runner(setting.runner),
        store(setting.store.empty() ? folder / "store" : setting.store),
        jobs(service, runner, spool, lifecycle, metrics, std::move(setting.smooth)),
        durable_jobs(*store.records, *store.files, jobs, setting.durable),
        uploads(*store.records, *store.files, jobs) {
    lifecycle.move_to(LifecycleState::Serving);
    if (!uploads.start() || !durable_jobs.start()) throw std::runtime_error("the store does not open");
  }
  ~JobsHouse() {
    durable_jobs.stop();
    lifecycle.move_to(LifecycleState::Draining);
    runner.drain(std::chrono::milliseconds::zero());  // workers use what goes before the runner
  }

  SmoothService service;
  Lifecycle lifecycle;
  Metrics metrics;
  Spool spool;
  JobRunner runner;
  cli::TemporaryFolder folder;
  Store store;
  Jobs jobs;
  DurableJobs durable_jobs;
  Uploads uploads;
};

}  // namespace burnish::testing
