// The jobs with everything behind them, as Server wires them up, and no transport.
#pragma once

#include <chrono>
#include <utility>

#include "server/jobs/jobs.h"

namespace burnish::testing {

struct JobsSetting {
  RequestLimits limits = {};
  JobRunnerOptions runner = {.workers = 1};
  SmoothFunction smooth = {};
};

struct JobsHouse {
  explicit JobsHouse(JobsSetting setting = {})
      : service(setting.limits),
        runner(setting.runner),
        jobs(service, runner, spool, lifecycle, metrics, std::move(setting.smooth)) {
    lifecycle.move_to(LifecycleState::Serving);
  }
  ~JobsHouse() {
    runner.drain(std::chrono::milliseconds::zero());
  }  // workers use what goes before the runner

  SmoothService service;
  Lifecycle lifecycle;
  Metrics metrics;
  Spool spool;
  JobRunner runner;
  Jobs jobs;
};

}  // namespace burnish::testing
