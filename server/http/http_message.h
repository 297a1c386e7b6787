// Requests and responses as the gateway sees them: no socket, no HTTP library.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace burnish {

struct IgnoreCase {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const;
};

using HttpHeaders = std::map<std::string, std::string, IgnoreCase>;

struct HttpRequest {
  std::string method;  ///< "POST"
  std::string path;    ///< decoded, without the query
  std::multimap<std::string, std::string> query = {};
  HttpHeaders headers = {};
  std::shared_ptr<const std::string> body = {};  ///< shared with the job, which may outlive the answer

  std::string_view header(std::string_view name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string_view() : found->second;
  }
};

struct HttpResponse {
  int status = 200;
  HttpHeaders headers = {};  ///< with Content-Type
  std::string body = {};
};

}  // namespace burnish
