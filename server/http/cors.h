// Which web pages of other origins may call this server from a browser (CORS, the Fetch standard).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/http_message.h"

namespace burnish {

/// Immutable, so thread-safe.
class Cors {
 public:
  /// `origins` as browsers write them ("https://scans.example"); "*" allows all; empty: none.
  explicit Cors(std::vector<std::string> origins) : origins_(std::move(origins)) {}

  /// Adds to any answer what an allowed page needs to read it, and to that of a preflight what it may send.
  /// An origin that is not allowed gets nothing, so its browser keeps the answer from it.
  void allow(const HttpRequest& request, HttpResponse& response) const;

 private:
  bool allows(std::string_view origin) const;

  const std::vector<std::string> origins_;
};

}  // namespace burnish
