// The thin C++ client of burnishd: typed calls with deadlines that another thread can cancel. It knows the
// contract (proto/burnish/v1) and gRPC, nothing of the geometry. Errors come back as values; no exception
// crosses it.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>

#include "burnish/v1/smoothing.grpc.pb.h"

namespace burnish::client {

/// Why a call failed.
struct Error {
  grpc::StatusCode code = grpc::StatusCode::UNKNOWN;
  /// The server's stable cause, such as "index_out_of_range". Without word from the server: "unreachable",
  /// "cancelled", "deadline_exceeded", "too_large", "out_of_memory" or "internal".
  std::string cause;
  std::string message;  ///< a sentence that points at the place
  std::string field;    ///< the option to blame; else empty
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
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

struct CallOptions {
  std::optional<std::chrono::milliseconds> timeout = {};  ///< unset: as long as it takes
  std::stop_token stop = {};                              ///< a stop from any thread cancels the call
};

/// A request that serialises to more is refused here: gRPC aborts the process over 2 GB.
inline constexpr std::size_t kLargestRequestBytes = 2'000'000'000;

/// Connects on first use and again after a lost connection. Thread-safe: calls may overlap.
class SmoothingClient {
 public:
  /// `address` is HOST:PORT or any gRPC name; the connection is not encrypted.
  explicit SmoothingClient(const std::string& address);
  /// For other credentials. The channel's own message limits apply.
  explicit SmoothingClient(const std::shared_ptr<grpc::Channel>& channel);

  Result<v1::SmoothResponse> smooth(const v1::SmoothRequest& request, const CallOptions& options = {}) const;
  Result<v1::ListMethodsResponse> list_methods(const CallOptions& options = {}) const;

 private:
  std::unique_ptr<v1::SmoothingService::Stub> stub_;
};

}  // namespace burnish::client
