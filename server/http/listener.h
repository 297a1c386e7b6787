// A listening socket, TCP or Unix, and the loop that accepts from it.
#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>

#include "core/run/error.h"
#include "server/config.h"
#include "server/http/connection.h"

namespace burnish {

class Listener {
 public:
  /// A Unix socket's file is replaced when no server answers on it. Errors: BadOption, with what is in the
  /// way.
  static Result<std::unique_ptr<Listener>> open(const Address& address);
  ~Listener();  ///< removes the file of a Unix socket, unless it is another's by now
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  const Address& address() const { return address_; }  ///< with the port that was opened

  /// Accepts until `stop`. `take` owns the socket that it gets, non-blocking; when it returns false it does
  /// not, and the client is told `refusal()` and closed without anybody waiting for it.
  void run(const StopEvent& stop, const std::function<bool(int socket)>& take,
           const std::function<std::string()>& refusal);

 private:
  explicit Listener(Address address) : address_(std::move(address)) {}
  Result<> open_tcp();
  Result<> open_unix();
  Error failure(const std::string& why) const;

  Address address_;
  int socket_ = -1;
  ino_t file_ = 0;  ///< of a Unix socket
};

}  // namespace burnish
