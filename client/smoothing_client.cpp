#include "client/smoothing_client.h"

#include <grpcpp/create_channel.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <new>
#include <optional>

#include "client/retry.h"
#include "client/status_error.h"
#include "client/stream.h"

namespace burnish::client {
namespace {

using std::chrono::milliseconds;

/// The server allows a ping every 30 s and takes more for abuse.
constexpr int kKeepaliveMs = 60'000;
constexpr int kKeepalivePatienceMs = 20'000;
/// A retry before gRPC tries the connection again would fail unheard; its own defaults are 1 s and 2 min.
constexpr int kFirstReconnectMs = 100;
constexpr int kLongestReconnectMs = 5'000;

std::shared_ptr<grpc::Channel> open_channel(const std::string& address,
                                            const std::shared_ptr<grpc::ChannelCredentials>& credentials) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);  // meshes are far larger than gRPC's default of 4 MB
  arguments.SetMaxSendMessageSize(-1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepalivePatienceMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // a long job sends none
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirstReconnectMs);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kLongestReconnectMs);
  return grpc::CreateCustomChannel(address, credentials, arguments);
}

std::optional<Error> check_size(std::string_view what, std::size_t bytes) {
  if (bytes <= kLargestMeshBytes) return std::nullopt;
  return Error{grpc::StatusCode::RESOURCE_EXHAUSTED, "too_large",
               "the size of the " + std::string(what) + " is " + std::to_string(bytes) +
                   " bytes; the client carries up to " + std::to_string(kLargestMeshBytes)};
}

template <class Request>
std::optional<Error> check_sizes(const Request& request) {
  auto error = check_size("mesh", request.mesh().size());
  return error ? error : check_size("reference", request.reference().size());
}

/// gRPC aborts the process over a message of 2 GB, whatever the options say.
bool fits_one_message(std::size_t bytes, const CallOptions& options) {
  return bytes <= std::min(options.unary_bytes, kLargestMeshBytes);
}

void prepare(grpc::ClientContext& context, const Attempts& attempts, const CallOptions& options) {
  if (const auto deadline = attempts.deadline()) {
    context.set_deadline(
        std::chrono::system_clock::now() +
        std::chrono::duration_cast<std::chrono::system_clock::duration>(*deadline - Attempts::Clock::now()));
  }
  if (!options.token.empty()) context.AddMetadata("authorization", "Bearer " + options.token);
  if (!options.traceparent.empty()) context.AddMetadata("traceparent", options.traceparent);
  if (options.compression == Compression::Gzip) context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
}

/// Runs attempt(context) until it succeeds or its error is final.
template <class Reply, class Attempt>
Result<Reply> invoke(const CallOptions& options, Attempt&& attempt) try {
  Attempts attempts(options);
  for (;;) {
    grpc::ClientContext context;
    prepare(context, attempts, options);
    const std::stop_callback cancel(options.stop, [&context] { context.TryCancel(); });
    Result<Reply> reply = attempt(context);
    if (reply || !attempts.again(reply.error())) return reply;
  }
} catch (const std::bad_alloc&) {
  return Error{grpc::StatusCode::RESOURCE_EXHAUSTED, "out_of_memory", "the client ran out of memory"};
} catch (const std::exception& failure) {
  return Error{grpc::StatusCode::INTERNAL, "internal", failure.what()};
} catch (...) {
  return Error{grpc::StatusCode::INTERNAL, "internal", "the progress function failed"};
}

/// An attempt that is one message each way.
template <class Reply, class Call>
Result<Reply> unary(Call&& call) {
  Reply reply;
  const grpc::Status status = call(reply);
  if (!status.ok()) return error_from(status);
  return reply;
}

}  // namespace

SmoothingClient::SmoothingClient(const std::string& address)
    : SmoothingClient(open_channel(address, grpc::InsecureChannelCredentials())) {}

SmoothingClient::SmoothingClient(const std::string& address, const TlsOptions& tls)
    : SmoothingClient(
          open_channel(address, grpc::SslCredentials({tls.authority, tls.key, tls.certificate}))) {}

SmoothingClient::SmoothingClient(const std::shared_ptr<grpc::Channel>& channel)
    : stub_(v1::SmoothingService::NewStub(channel)) {}

Result<v1::SmoothResponse> SmoothingClient::smooth(const v1::SmoothRequest& request,
                                                   const CallOptions& options) const {
  const std::size_t option_bytes = request.options().ByteSizeLong();
  if (auto error = check_sizes(request)) return *error;
  if (auto error = check_size("options", option_bytes)) return *error;
  const std::size_t bytes = request.mesh().size() + request.reference().size() + option_bytes;
  const bool by_stream = options.progress || !fits_one_message(bytes, options);
  return invoke<v1::SmoothResponse>(options, [&](grpc::ClientContext& context) {
    if (by_stream) return smooth_by_stream(*stub_, context, request, options.progress);
    return unary<v1::SmoothResponse>(
        [&](v1::SmoothResponse& reply) { return stub_->Smooth(&context, request, &reply); });
  });
}

Result<v1::CompareResponse> SmoothingClient::compare(const v1::CompareRequest& request,
                                                     const CallOptions& options) const {
  if (auto error = check_sizes(request)) return *error;
  const bool by_stream = !fits_one_message(request.mesh().size() + request.reference().size(), options);
  return invoke<v1::CompareResponse>(options, [&](grpc::ClientContext& context) {
    if (by_stream) return compare_by_stream(*stub_, context, request);
    return unary<v1::CompareResponse>(
        [&](v1::CompareResponse& reply) { return stub_->Compare(&context, request, &reply); });
  });
}

Result<v1::ListMethodsResponse> SmoothingClient::list_methods(const CallOptions& options) const {
  return invoke<v1::ListMethodsResponse>(options, [&](grpc::ClientContext& context) {
    return unary<v1::ListMethodsResponse>(
        [&](v1::ListMethodsResponse& reply) { return stub_->ListMethods(&context, {}, &reply); });
  });
}

}  // namespace burnish::client
