// Errors, named by cause. Every function that can fail on foreign input returns Result<T>; exceptions are for
// our own broken invariants and for memory running out. docs/decisions/0001-error-type.md says why.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace burnish {

/// Why something failed. server/status_map.h gives each its gRPC status, HTTP status and exit code.
enum class Cause : std::uint8_t {
  // The options.
  BadOption,      ///< a value out of range, of the wrong type, or that does not parse
  UnknownOption,  ///< a parameter or option that the method does not have
  UnknownMethod,  ///< no method of that name
  // The mesh.
  UnsupportedFormat,  ///< none of the known formats, or a variant that cannot be carried
  MalformedMesh,      ///< the bytes break the rules of their format
  IndexOutOfRange,    ///< a face names a vertex, normal or texture coordinate that does not exist
  NonFinitePosition,  ///< a coordinate is NaN, infinite, or too large to compute with
  EmptyMesh,          ///< no vertex or no face
  NotATriangleMesh,   ///< a Draco point cloud
  TooLarge,           ///< more bytes, vertices or triangles than the limit
  CannotEncode,       ///< the result cannot be written in the format that was asked for
  // The run.
  Cancelled,         ///< the caller went away or asked to stop
  DeadlineExceeded,  ///< the caller's deadline, or the server's limit of time, passed
  OutOfMemory,
  Internal,
  // The service.
  QueueFull,    ///< no place for another job now
  MemoryFull,   ///< no memory or spool space for another job now
  StorageFull,  ///< the disk has no room for the request
  ShuttingDown,
  BadRequest,        ///< the request breaks the rules of its transport
  RequestTimeout,    ///< the request did not come whole in time
  NotFound,          ///< no such path, job, upload or mesh, or not the caller's
  MethodNotAllowed,  ///< HTTP: the path exists, the verb does not
  NotAcceptable,     ///< HTTP: the answer has no type that the caller accepts
  // Jobs that are kept.
  Expired,               ///< the job's result is gone
  NotReady,              ///< the job has not ended, or has no result to give
  UploadOffsetMismatch,  ///< the bytes do not follow those that are there
  UploadCorrupt,         ///< the bytes are not those that were announced
  IdempotencyKeyReused,  ///< the key came before, with another request
  IdempotencyKeyBusy,    ///< a request with this key is being received
  RangeNotSatisfiable,   ///< the part asked for begins behind the end
  // Who may.
  Unauthenticated,  ///< no token, or one that is not known
  QuotaExceeded,    ///< more than this token may have
  // The caller's side.
  Unreachable,  ///< client: the server does not answer
  FileError,    ///< command line: a file cannot be read or written
};

/// All causes, for tables and the tests that visit every row.
std::span<const Cause> all_causes();

/// Stable name on every wire, in snake case: "index_out_of_range".
std::string_view cause_code(Cause cause);

/// A cause and a sentence that points: "triangle 812 uses vertex 9001 of 9000 (line 10321)".
struct Error {
  Cause cause = Cause::Internal;
  std::string message;
  std::string field = {};  ///< for options: the parameter's name; else empty
  /// For refusals that pass: when trying again may help. Zero: not known.
  std::chrono::milliseconds retry_after = {};

  friend bool operator==(const Error&, const Error&) = default;
};

/// A value or an Error. `Result<>` carries no value.
template <class T = std::monostate>
class [[nodiscard]] Result {
 public:
  Result() requires std::is_same_v<T, std::monostate> : state_(T{}) {}
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const& { return std::get<1>(state_); }
  Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

/// A thing that the caller should know although the job succeeded.
struct Warning {
  std::string code;     ///< stable, snake case: "non_manifold_edges"
  std::string message;  ///< one sentence that names the first place
  std::uint32_t count = 0;

  friend bool operator==(const Warning&, const Warning&) = default;
};

}  // namespace burnish
