// Requests and responses as the gateway sees them: no socket, no HTTP library.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/run/error.h"

namespace burnish {

struct IgnoreCase {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const;
};

using HttpHeaders = std::map<std::string, std::string, IgnoreCase>;

/// Bytes with whatever keeps them alive: a job may outlive the answer to its request.
struct SharedBytes {
  std::string_view bytes = {};
  std::shared_ptr<const void> owner = {};
};

/// One part of a multipart/form-data body.
struct FormPart {
  std::string name;
  std::string content_type;  ///< as sent; empty when absent
  SharedBytes content;
};

struct HttpRequest {
  std::string method;  ///< "POST"
  std::string path;    ///< decoded, without the query
  std::multimap<std::string, std::string> query = {};
  HttpHeaders headers = {};
  SharedBytes body = {};             ///< decompressed; empty when the body was multipart
  std::vector<FormPart> parts = {};  ///< of a multipart body, in the order sent

  std::string_view header(std::string_view name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string_view() : found->second;
  }
};

struct HttpResponse {
  int status = 200;
  HttpHeaders headers = {};  ///< with Content-Type
  std::string body = {};
  SharedBytes file = {};  ///< instead of `body`: sent as it lies, neither copied nor compressed
  /// Instead of both: sends pieces of a body whose length nobody knows, and returns at its end. `send` is
  /// false when the client does not take them; `gone` when it left, or the server ends.
  std::function<void(const std::function<bool(std::string_view)>& send, const std::function<bool()>& gone)>
      stream = {};
};

/// Takes the bytes of a body as they come, instead of the spool.
class BodyTaker {
 public:
  virtual ~BodyTaker() = default;
  virtual Result<> take(std::string_view bytes) = 0;
  /// All of the body has come.
  virtual Result<HttpResponse> finish() = 0;
};

}  // namespace burnish
