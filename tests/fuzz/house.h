// The gateway with everything behind it and small limits, reached through a connection in memory.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/http/http_server.h"
#include "tests/fuzz/round_trip.h"

namespace burnish::fuzz {

class House {
 public:
  House();
  ~House();

  /// Everything that the server says to `bytes`; aborts when that is no HTTP, or blames the server.
  std::string answer(std::string_view bytes);

  SmoothService service{{.mesh = kLimits, .max_iterations = 20, .max_option_bytes = 4 << 10}};

 private:
  Lifecycle lifecycle_;
  Metrics metrics_;
  Spool spool_;
  JobRunner runner_;
  Jobs jobs_;
  Gateway gateway_;
  std::unique_ptr<HttpServer> server_;
};

/// One for all inputs.
House& house();

}  // namespace burnish::fuzz
