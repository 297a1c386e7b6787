// The thin C++ client of burnishd: typed calls with deadlines, retries and progress, that another thread can
// stop. It knows the contract (proto/burnish/v1) and gRPC, nothing of the geometry. Errors come back as
// values; no exception crosses it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "client/call_options.h"
#include "client/result.h"

namespace burnish::client {

/// PEM texts, not names of files.
struct TlsOptions {
  std::string authority = {};  ///< that the server's certificate comes from; empty: those of the system
  std::string certificate = {}, key = {};  ///< the caller's own, for servers that ask for one
};

/// Connects on first use and again after a lost connection. Thread-safe: calls may overlap. Each call blocks
/// its thread until its answer, its timeout or its stop.
class SmoothingClient {
 public:
  /// `address` is HOST:PORT, "unix:PATH" or any gRPC name; the connection is not encrypted.
  explicit SmoothingClient(const std::string& address);
  /// The connection is encrypted.
  SmoothingClient(const std::string& address, const TlsOptions& tls);
  /// For other credentials. The channel's own limits and keepalive apply.
  explicit SmoothingClient(const std::shared_ptr<grpc::Channel>& channel);

  /// Smooths one mesh, in one message or by stream, as its size and the options want.
  Result<v1::SmoothResponse> smooth(const v1::SmoothRequest& request, const CallOptions& options = {}) const;
  /// Measures one mesh against another; likewise.
  Result<v1::CompareResponse> compare(const v1::CompareRequest& request,
                                      const CallOptions& options = {}) const;
  /// Every method with its parameters.
  Result<v1::ListMethodsResponse> list_methods(const CallOptions& options = {}) const;

 private:
  std::unique_ptr<v1::SmoothingService::Stub> stub_;
};

}  // namespace burnish::client
