#include "client/smoothing_client.h"

#include <grpcpp/create_channel.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <new>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace burnish::client {
namespace {

std::shared_ptr<grpc::Channel> open_channel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);  // meshes are far larger than gRPC's default of 4 MB
  arguments.SetMaxSendMessageSize(-1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// The cause when the status did not come from a burnishd, or not from its handlers.
std::string cause_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::UNAVAILABLE:
      return "unreachable";
    case grpc::StatusCode::CANCELLED:
      return "cancelled";
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return "deadline_exceeded";
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return "too_large";  // the transport's limit of a message
    default:
      return "internal";
  }
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

Error error_from(const grpc::Status& status) {
  Error error{status.error_code(), cause_of(status.error_code()), status.error_message(), ""};
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return error;
  for (const google::protobuf::Any& detail : details.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::BadRequest bad_request;
    if (detail.UnpackTo(&info) && info.domain() == "burnish") error.cause = lower_case(info.reason());
    if (detail.UnpackTo(&bad_request) && bad_request.field_violations_size() > 0) {
      error.field = bad_request.field_violations(0).field();
    }
  }
  return error;
}

/// Runs call(context, reply) with the options' deadline and stop.
template <class Reply, class Call>
Result<Reply> invoke(const CallOptions& options, Call&& call) try {
  grpc::ClientContext context;
  if (options.timeout) context.set_deadline(std::chrono::system_clock::now() + *options.timeout);
  const std::stop_callback cancel(options.stop, [&context] { context.TryCancel(); });
  Reply reply;
  const grpc::Status status = call(context, reply);
  if (!status.ok()) return error_from(status);
  return reply;
} catch (const std::bad_alloc&) {
  return Error{grpc::StatusCode::RESOURCE_EXHAUSTED, "out_of_memory", "the client ran out of memory", ""};
} catch (const std::exception& failure) {
  return Error{grpc::StatusCode::INTERNAL, "internal", failure.what(), ""};
}

}  // namespace

SmoothingClient::SmoothingClient(const std::string& address) : SmoothingClient(open_channel(address)) {}

SmoothingClient::SmoothingClient(const std::shared_ptr<grpc::Channel>& channel)
    : stub_(v1::SmoothingService::NewStub(channel)) {}

Result<v1::SmoothResponse> SmoothingClient::smooth(const v1::SmoothRequest& request,
                                                   const CallOptions& options) const {
  if (const std::size_t bytes = request.ByteSizeLong(); bytes > kLargestRequestBytes) {
    return Error{grpc::StatusCode::RESOURCE_EXHAUSTED, "too_large",
                 "the request has " + std::to_string(bytes) + " bytes, one call carries " +
                     std::to_string(kLargestRequestBytes),
                 ""};
  }
  return invoke<v1::SmoothResponse>(options, [&](grpc::ClientContext& context, v1::SmoothResponse& reply) {
    return stub_->Smooth(&context, request, &reply);
  });
}

Result<v1::ListMethodsResponse> SmoothingClient::list_methods(const CallOptions& options) const {
  return invoke<v1::ListMethodsResponse>(options,
                                         [&](grpc::ClientContext& context, v1::ListMethodsResponse& reply) {
                                           return stub_->ListMethods(&context, {}, &reply);
                                         });
}

}  // namespace burnish::client
