#include "tests/fuzz/house.h"

#include <cstdio>
#include <cstdlib>

#include "server/observe/log.h"

namespace burnish::fuzz {

House::House()
    : runner_({.workers = 1, .queue = 1, .threads = 1}),
      jobs_(service, runner_, spool_, lifecycle_, metrics_),
      gateway_(jobs_, {.cors_origins = {"http://localhost:3000"}}),
      server_(HttpServer::without_port({}, gateway_, jobs_)) {
  lifecycle_.move_to(LifecycleState::Serving);
}

House::~House() { runner_.drain(std::chrono::milliseconds::zero()); }

std::string House::answer(std::string_view bytes) {
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
