#include "server/status_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "server/grpc/grpc_status.h"

namespace burnish {
namespace {

TEST(StatusMap, HasARowForEveryCause) {
  for (const Cause cause : all_causes()) {
    const StatusRow& row = status_of(cause);
    EXPECT_EQ(row.cause, cause) << cause_code(cause);
    EXPECT_GE(row.http_status, 400) << cause_code(cause);
    EXPECT_GE(row.exit_code, 2) << cause_code(cause);
    EXPECT_LE(row.exit_code, 6) << cause_code(cause);
    EXPECT_GT(std::string_view(row.title).size(), 3u) << cause_code(cause);
  }
}

TEST(StatusMap, FindsEveryCauseByItsCodeInEitherCase) {
  for (const Cause cause : all_causes()) {
    std::string code(cause_code(cause));
    EXPECT_EQ(cause_from_code(code), cause);
    std::ranges::transform(code, code.begin(), [](unsigned char c) { return std::toupper(c); });
    EXPECT_EQ(cause_from_code(code), cause);
  }
  EXPECT_EQ(cause_from_code("no_such_code"), Cause::Internal);
  EXPECT_EQ(cause_from_code("queue_ful"), Cause::Internal);
}

// Clients branch on these: a change here breaks them.
TEST(StatusMap, KeepsItsStableRows) {
  struct Expected {
    Cause cause;
    std::string_view code;
    grpc::StatusCode grpc;
    int http, exit;
  };
  const Expected rows[] = {
      {Cause::BadOption, "bad_option", grpc::INVALID_ARGUMENT, 400, 2},
      {Cause::UnknownOption, "unknown_option", grpc::INVALID_ARGUMENT, 400, 2},
      {Cause::UnknownMethod, "unknown_method", grpc::INVALID_ARGUMENT, 400, 2},
      {Cause::UnsupportedFormat, "unsupported_format", grpc::INVALID_ARGUMENT, 415, 3},
      {Cause::MalformedMesh, "malformed_mesh", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::IndexOutOfRange, "index_out_of_range", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::NonFinitePosition, "non_finite_position", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::EmptyMesh, "empty_mesh", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::NotATriangleMesh, "not_a_triangle_mesh", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::TooLarge, "too_large", grpc::RESOURCE_EXHAUSTED, 413, 4},
      {Cause::CannotEncode, "cannot_encode", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::Cancelled, "cancelled", grpc::CANCELLED, 499, 4},
      {Cause::DeadlineExceeded, "deadline_exceeded", grpc::DEADLINE_EXCEEDED, 504, 4},
      {Cause::OutOfMemory, "out_of_memory", grpc::RESOURCE_EXHAUSTED, 503, 5},
      {Cause::Internal, "internal", grpc::INTERNAL, 500, 5},
      {Cause::QueueFull, "queue_full", grpc::RESOURCE_EXHAUSTED, 429, 4},
      {Cause::MemoryFull, "memory_full", grpc::RESOURCE_EXHAUSTED, 429, 4},
      {Cause::StorageFull, "storage_full", grpc::RESOURCE_EXHAUSTED, 507, 5},
      {Cause::ShuttingDown, "shutting_down", grpc::UNAVAILABLE, 503, 5},
      {Cause::BadRequest, "bad_request", grpc::INVALID_ARGUMENT, 400, 2},
      {Cause::RequestTimeout, "request_timeout", grpc::DEADLINE_EXCEEDED, 408, 4},
      {Cause::NotFound, "not_found", grpc::NOT_FOUND, 404, 2},
      {Cause::MethodNotAllowed, "method_not_allowed", grpc::UNIMPLEMENTED, 405, 2},
      {Cause::NotAcceptable, "not_acceptable", grpc::INVALID_ARGUMENT, 406, 2},
      {Cause::Expired, "expired", grpc::NOT_FOUND, 410, 2},
      {Cause::NotReady, "not_ready", grpc::FAILED_PRECONDITION, 409, 2},
      {Cause::UploadOffsetMismatch, "upload_offset_mismatch", grpc::FAILED_PRECONDITION, 409, 2},
      {Cause::UploadCorrupt, "upload_corrupt", grpc::INVALID_ARGUMENT, 422, 3},
      {Cause::IdempotencyKeyReused, "idempotency_key_reused", grpc::INVALID_ARGUMENT, 422, 2},
      {Cause::IdempotencyKeyBusy, "idempotency_key_busy", grpc::ABORTED, 409, 4},
      {Cause::RangeNotSatisfiable, "range_not_satisfiable", grpc::OUT_OF_RANGE, 416, 2},
      {Cause::Unauthenticated, "unauthenticated", grpc::UNAUTHENTICATED, 401, 2},
      {Cause::QuotaExceeded, "quota_exceeded", grpc::RESOURCE_EXHAUSTED, 429, 4},
      {Cause::Unreachable, "unreachable", grpc::UNAVAILABLE, 503, 5},
      {Cause::FileError, "file_error", grpc::INTERNAL, 500, 6},
  };
  std::set<Cause> seen;
  for (const Expected& row : rows) {
    EXPECT_EQ(cause_code(row.cause), row.code);
    EXPECT_EQ(status_of(row.cause).grpc_code, row.grpc) << row.code;
    EXPECT_EQ(status_of(row.cause).http_status, row.http) << row.code;
    EXPECT_EQ(status_of(row.cause).exit_code, row.exit) << row.code;
    seen.insert(row.cause);
  }
  EXPECT_EQ(seen.size(), all_causes().size()) << "a cause has no row here";
}

}  // namespace
}  // namespace burnish
