#include "server/grpc/grpc_status.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/status_map.h"

namespace burnish {
namespace {

std::string upper_case(std::string_view code) {
  std::string result(code);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return std::toupper(c); });
  return result;
}

}  // namespace

grpc::Status to_grpc_status(const Error& error, std::string_view request_id) {
  const StatusRow& row = status_of(error.cause);
  google::rpc::Status status;
  status.set_code(row.grpc_code);
  status.set_message(error.message);

  google::rpc::ErrorInfo info;
  info.set_reason(upper_case(cause_code(error.cause)));
  info.set_domain("burnish");
  (*info.mutable_metadata())["request_id"] = std::string(request_id);
  status.add_details()->PackFrom(info);

  if (!error.field.empty()) {
    google::rpc::BadRequest bad_request;
    auto* violation = bad_request.add_field_violations();
    violation->set_field(error.field);
    violation->set_description(error.message);
    status.add_details()->PackFrom(bad_request);
  }
  if (error.cause == Cause::QueueFull) {
    google::rpc::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(1);
    status.add_details()->PackFrom(retry);
  }
  return {static_cast<grpc::StatusCode>(row.grpc_code), error.message, status.SerializeAsString()};
}

}  // namespace burnish
