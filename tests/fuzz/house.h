// The gateway with everything behind it and small limits, reached through a connection in memory.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/http/http_server.h"
#include "tests/fuzz/round_trip.h"
#include "tests/server/jobs_house.h"

namespace burnish::fuzz {

class House {
 public:
  House();

  /// Everything that the server says to `bytes`; aborts when that is no HTTP, or blames the server.
  std::string answer(std::string_view bytes);

 private:
  testing::JobsHouse house_;
  Gateway gateway_;
  std::unique_ptr<HttpServer> server_;
  unsigned inputs_ = 0;
};

/// One for all inputs.
House& house();

}  // namespace burnish::fuzz
