// What a call of the client gives back: a value, or an error named by cause.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <variant>

#include <grpcpp/support/status.h>

namespace burnish::client {

/// Why a call failed.
struct Error {
  grpc::StatusCode code = grpc::StatusCode::UNKNOWN;
  /// The server's stable cause, such as "index_out_of_range". Without word from the server: "unreachable",
  /// "cancelled", "deadline_exceeded", "too_large", "out_of_memory" or "internal".
  std::string cause;
  std::string message;     ///< a sentence that points at the place
  std::string field = {};  ///< the option to blame; else empty
  std::chrono::milliseconds retry_after =
      {};            ///< when the server says that trying again may help; 0: no word
  int attempts = 0;  ///< how often the call was sent
};

/// A value or an Error.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() { return std::get<0>(state_); }
  const T& value() const { return std::get<0>(state_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  Error& error() { return std::get<1>(state_); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

}  // namespace burnish::client
