#include "server/grpc/grpc_status.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <string>

#include <google/protobuf/util/time_util.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/observe/log.h"
#include "server/status_map.h"

namespace burnish {
namespace {

using google::protobuf::util::TimeUtil;

std::string upper_case(std::string_view code) {
  std::string result(code);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return std::toupper(c); });
  return result;
}

/// For refusals that pass soon although nobody knows when.
constexpr std::chrono::milliseconds kSoon{1000};

std::chrono::milliseconds retry_after(const Error& error) {
  if (error.retry_after > std::chrono::milliseconds::zero()) return error.retry_after;
  const bool passes = error.cause == Cause::QueueFull || error.cause == Cause::MemoryFull ||
                      error.cause == Cause::ShuttingDown;
  return passes ? kSoon : std::chrono::milliseconds::zero();
}

}  // namespace

grpc::Status to_grpc_status(const Error& error, std::string_view request_id) {
  const StatusRow& row = status_of(error.cause);
  // Foreign text must fit into gRPC's metadata.
  const std::string message = printable(error.message);
  google::rpc::Status status;
  status.set_code(row.grpc_code);
  status.set_message(message);

  google::rpc::ErrorInfo info;
  info.set_reason(upper_case(cause_code(error.cause)));
  info.set_domain("burnish");
  (*info.mutable_metadata())["request_id"] = std::string(request_id);
  status.add_details()->PackFrom(info);

  if (!error.field.empty()) {
    google::rpc::BadRequest bad_request;
    auto* violation = bad_request.add_field_violations();
    violation->set_field(printable(error.field, 100));
    violation->set_description(message);
    status.add_details()->PackFrom(bad_request);
  }
  if (const auto delay = retry_after(error); delay.count() > 0) {
    google::rpc::RetryInfo retry;
    *retry.mutable_retry_delay() = TimeUtil::MillisecondsToDuration(delay.count());
    status.add_details()->PackFrom(retry);
  }
  return {static_cast<grpc::StatusCode>(row.grpc_code), message, status.SerializeAsString()};
}

}  // namespace burnish
