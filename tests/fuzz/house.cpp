#include "tests/fuzz/house.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "server/observe/log.h"

namespace burnish::fuzz {

House::House()
    : house_({.limits = {.mesh = kLimits, .max_iterations = 20, .max_option_bytes = 4 << 10},
              .runner = {.workers = 1, .queue = 1, .threads = 1},
              .durable = {.max_jobs = 4}}),
      gateway_(house_.jobs, house_.durable_jobs, house_.uploads, {.cors_origins = {"http://localhost:3000"}}),
      server_(HttpServer::without_port({}, gateway_, house_.jobs)) {}

std::string House::answer(std::string_view bytes) {
  constexpr unsigned kInputsADay = 256;  // what is kept goes out of time as it would in a server's life
  if (++inputs_ % kInputsADay == 0) {
    const WallTime tomorrow = std::chrono::system_clock::now() + std::chrono::hours(25);
    house_.uploads.sweep(tomorrow);
    if (!house_.durable_jobs.sweep(tomorrow)) std::abort();
  }
  std::string answer = server_->answer(bytes);
  const bool http = answer.empty() || answer.starts_with("HTTP/1.1 ");
  if (!http || answer.starts_with("HTTP/1.1 500")) {
    std::fprintf(stderr, "answered: %s\n", answer.c_str());
    std::abort();
  }
  return answer;
}

House& house() {
  static House house = [] {
    set_up_log("off");
    return House();
  }();
  return house;
}

}  // namespace burnish::fuzz
