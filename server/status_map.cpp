#include "server/status_map.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace burnish {
namespace {

// gRPC codes by number, as https://grpc.github.io/grpc/core/md_doc_statuscodes.html lists them.
enum : int {
  kCancelled = 1,
  kInvalidArgument = 3,
  kDeadlineExceeded = 4,
  kNotFound = 5,
  kResourceExhausted = 8,
  kFailedPrecondition = 9,
  kAborted = 10,
  kOutOfRange = 11,
  kUnimplemented = 12,
  kInternal = 13,
  kUnavailable = 14,
  kUnauthenticated = 16,
};

constexpr std::array kRows{
    StatusRow{Cause::BadOption, kInvalidArgument, 400, 2, "Bad option"},
    StatusRow{Cause::UnknownOption, kInvalidArgument, 400, 2, "Unknown option"},
    StatusRow{Cause::UnknownMethod, kInvalidArgument, 400, 2, "Unknown method"},
    StatusRow{Cause::UnsupportedFormat, kInvalidArgument, 415, 3, "Unsupported format"},
    StatusRow{Cause::MalformedMesh, kInvalidArgument, 422, 3, "Malformed mesh"},
    StatusRow{Cause::IndexOutOfRange, kInvalidArgument, 422, 3, "Index out of range"},
    StatusRow{Cause::NonFinitePosition, kInvalidArgument, 422, 3, "Position is not finite"},
    StatusRow{Cause::EmptyMesh, kInvalidArgument, 422, 3, "Empty mesh"},
    StatusRow{Cause::NotATriangleMesh, kInvalidArgument, 422, 3, "Not a triangle mesh"},
    StatusRow{Cause::TooLarge, kResourceExhausted, 413, 4, "Too large"},
    StatusRow{Cause::CannotEncode, kInvalidArgument, 422, 3, "Cannot write the result"},
    StatusRow{Cause::Cancelled, kCancelled, 499, 4, "Cancelled"},
    StatusRow{Cause::DeadlineExceeded, kDeadlineExceeded, 504, 4, "Out of time"},
    StatusRow{Cause::OutOfMemory, kResourceExhausted, 503, 5, "Out of memory"},
    StatusRow{Cause::Internal, kInternal, 500, 5, "Internal error"},
    StatusRow{Cause::QueueFull, kResourceExhausted, 429, 4, "Queue full"},
    StatusRow{Cause::MemoryFull, kResourceExhausted, 429, 4, "Memory full"},
    StatusRow{Cause::StorageFull, kResourceExhausted, 507, 5, "Storage full"},
    StatusRow{Cause::ShuttingDown, kUnavailable, 503, 5, "Shutting down"},
    StatusRow{Cause::BadRequest, kInvalidArgument, 400, 2, "Bad request"},
    StatusRow{Cause::RequestTimeout, kDeadlineExceeded, 408, 4, "Request timeout"},
    StatusRow{Cause::NotFound, kNotFound, 404, 2, "Not found"},
    StatusRow{Cause::MethodNotAllowed, kUnimplemented, 405, 2, "Method not allowed"},
    StatusRow{Cause::NotAcceptable, kInvalidArgument, 406, 2, "Not acceptable"},
    StatusRow{Cause::Expired, kNotFound, 410, 2, "Gone"},
    StatusRow{Cause::NotReady, kFailedPrecondition, 409, 2, "Not ready"},
    StatusRow{Cause::UploadOffsetMismatch, kFailedPrecondition, 409, 2, "Upload offset mismatch"},
    StatusRow{Cause::UploadCorrupt, kInvalidArgument, 422, 3, "Upload corrupt"},
    StatusRow{Cause::IdempotencyKeyReused, kInvalidArgument, 422, 2, "Idempotency key reused"},
    StatusRow{Cause::IdempotencyKeyBusy, kAborted, 409, 4, "Idempotency key busy"},
    StatusRow{Cause::RangeNotSatisfiable, kOutOfRange, 416, 2, "Range not satisfiable"},
    StatusRow{Cause::Unauthenticated, kUnauthenticated, 401, 2, "Unauthenticated"},
    StatusRow{Cause::QuotaExceeded, kResourceExhausted, 429, 4, "Quota exceeded"},
    StatusRow{Cause::Unreachable, kUnavailable, 503, 5, "Server unreachable"},
    StatusRow{Cause::FileError, kInternal, 500, 6, "File error"},
};

constexpr bool rows_follow_the_enum() {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (kRows[i].cause != static_cast<Cause>(i)) return false;
  }
  return true;
}
static_assert(rows_follow_the_enum(), "status_of() finds a cause's row by its number");
static_assert(kRows.size() == static_cast<std::size_t>(Cause::FileError) + 1, "a row for every cause");

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, {}, [](unsigned char c) { return std::tolower(c); },
      [](unsigned char c) { return std::tolower(c); });
}

}  // namespace

const StatusRow& status_of(Cause cause) { return kRows.at(static_cast<std::size_t>(cause)); }

bool comes_from_servers(Cause cause) { return cause != Cause::Unreachable && cause != Cause::FileError; }

Cause cause_from_code(std::string_view code) {
  for (const StatusRow& row : kRows) {
    if (equal_ignoring_case(cause_code(row.cause), code)) return row.cause;
  }
  return Cause::Internal;
}

}  // namespace burnish
