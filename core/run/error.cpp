#include "core/run/error.h"

#include <array>

namespace burnish {
namespace {

struct Row {
  Cause cause;
  std::string_view code;
};

constexpr auto kRows = std::to_array<Row>({
    {Cause::BadOption, "bad_option"},
    {Cause::UnknownOption, "unknown_option"},
    {Cause::UnknownMethod, "unknown_method"},
    {Cause::UnsupportedFormat, "unsupported_format"},
    {Cause::MalformedMesh, "malformed_mesh"},
    {Cause::IndexOutOfRange, "index_out_of_range"},
    {Cause::NonFinitePosition, "non_finite_position"},
    {Cause::EmptyMesh, "empty_mesh"},
    {Cause::NotATriangleMesh, "not_a_triangle_mesh"},
    {Cause::TooLarge, "too_large"},
    {Cause::CannotEncode, "cannot_encode"},
    {Cause::Cancelled, "cancelled"},
    {Cause::DeadlineExceeded, "deadline_exceeded"},
    {Cause::OutOfMemory, "out_of_memory"},
    {Cause::Internal, "internal"},
    {Cause::QueueFull, "queue_full"},
    {Cause::MemoryFull, "memory_full"},
    {Cause::StorageFull, "storage_full"},
    {Cause::ShuttingDown, "shutting_down"},
    {Cause::BadRequest, "bad_request"},
    {Cause::RequestTimeout, "request_timeout"},
    {Cause::NotFound, "not_found"},
    {Cause::MethodNotAllowed, "method_not_allowed"},
    {Cause::NotAcceptable, "not_acceptable"},
    {Cause::Expired, "expired"},
    {Cause::NotReady, "not_ready"},
    {Cause::UploadOffsetMismatch, "upload_offset_mismatch"},
    {Cause::UploadCorrupt, "upload_corrupt"},
    {Cause::IdempotencyKeyReused, "idempotency_key_reused"},
    {Cause::IdempotencyKeyBusy, "idempotency_key_busy"},
    {Cause::RangeNotSatisfiable, "range_not_satisfiable"},
    {Cause::Unauthenticated, "unauthenticated"},
    {Cause::QuotaExceeded, "quota_exceeded"},
    {Cause::Unreachable, "unreachable"},
    {Cause::FileError, "file_error"},
});

constexpr auto kCauses = [] {
  std::array<Cause, kRows.size()> causes{};
  for (std::size_t i = 0; i < causes.size(); ++i) causes[i] = kRows[i].cause;
  return causes;
}();

}  // namespace

std::span<const Cause> all_causes() { return kCauses; }

std::string_view cause_code(Cause cause) {
  for (const Row& row : kRows) {
    if (row.cause == cause) return row.code;
  }
  return "internal";
}

}  // namespace burnish
