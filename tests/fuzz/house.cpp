#include "tests/fuzz/house.h"

#include <cstdio>
#include <cstdlib>

#include "server/observe/log.h"

namespace burnish::fuzz {

House::House()
    : house_({.limits = {.mesh = kLimits, .max_iterations = 20, .max_option_bytes = 4 << 10},
              .runner = {.workers = 1, .queue = 1, .threads = 1}}),
      gateway_(house_.jobs, {.cors_origins = {"http://localhost:3000"}}),
      server_(HttpServer::without_port({}, gateway_, house_.jobs)) {}

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
