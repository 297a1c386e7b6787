#include "client/status_error.h"

#include <algorithm>
#include <cctype>
#include <cstdint>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace burnish::client {
namespace {

/// More than anyone waits; bounds what a foreign server can make the clock's arithmetic do.
constexpr std::int64_t kLongestRetryAfterSeconds = 24 * 3600;

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

std::chrono::milliseconds delay_of(const google::protobuf::Duration& delay) {
  if (delay.seconds() >= kLongestRetryAfterSeconds) return std::chrono::seconds(kLongestRetryAfterSeconds);
  if (delay.seconds() < 0 || delay.nanos() < 0) return {};
  return std::chrono::seconds(delay.seconds()) +
         std::chrono::ceil<std::chrono::milliseconds>(std::chrono::nanoseconds(delay.nanos()));
}

}  // namespace

Error error_from(const grpc::Status& status) {
  Error error{status.error_code(), cause_of(status.error_code()), status.error_message()};
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return error;
  for (const google::protobuf::Any& detail : details.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::BadRequest bad_request;
    google::rpc::RetryInfo retry;
    if (detail.UnpackTo(&info) && info.domain() == "burnish") error.cause = lower_case(info.reason());
    if (detail.UnpackTo(&bad_request) && bad_request.field_violations_size() > 0) {
      error.field = bad_request.field_violations(0).field();
    }
    if (detail.UnpackTo(&retry)) error.retry_after = delay_of(retry.retry_delay());
  }
  return error;
}

}  // namespace burnish::client
