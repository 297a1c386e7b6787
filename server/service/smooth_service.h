// The use case, without transport: bytes and options in, bytes and report out. gRPC, HTTP and the command
// line's local mode all call this, so their results are the same bytes.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "burnish/v1/smoothing.pb.h"
#include "core/io/codec.h"
#include "core/run/run_control.h"
#include "server/service/limits.h"

namespace burnish {

/// One job. The views must stay alive until smooth() returns.
struct SmoothJob {
  std::string_view mesh;
  std::optional<Format> format = {};
  std::string_view reference = {};  ///< empty: measure against the input
  std::optional<Format> reference_format = {};
  v1::SmoothOptions options = {};
  std::string request_id = {};
  double queue_ms = 0;  ///< time spent waiting, for the report
  /// Called as each stage starts, and during smoothing, on the thread that runs the job; must not block.
  std::function<void(v1::SmoothStage stage, double fraction)> progress = {};
};

struct SmoothResult {
  std::string mesh;
  Format format = Format::Obj;
  v1::SmoothReport report;
};

/// Two meshes to measure. The views must stay alive until compare() returns.
struct CompareJob {
  std::string_view reference;
  std::optional<Format> reference_format = {};
  std::string_view mesh;
  std::optional<Format> format = {};
  std::string request_id = {};
  double queue_ms = 0;
};

/// What smooths and compares: the service, or what stands in for it.
using SmoothFunction = std::function<Result<SmoothResult>(const SmoothJob&, const RunControl&)>;
using CompareFunction = std::function<Result<v1::CompareResponse>(const CompareJob&, const RunControl&)>;

/// Stateless; safe to call from many threads at once.
class SmoothService {
 public:
  explicit SmoothService(RequestLimits limits = {}) : limits_(limits) {}

  /// Checks what can be checked without decoding: sizes, method, parameters, output options. Cheap, so
  /// transports call it before they queue. Errors: TooLarge, EmptyMesh, UnknownMethod, UnknownOption,
  /// BadOption.
  Result<> check(const SmoothJob& job) const;
  Result<> check(const CompareJob& job) const;
  /// The part of it that needs no mesh, for requests whose bytes are still to come.
  Result<> check(const v1::SmoothOptions& options) const;
  Result<> check_size(std::uint64_t bytes, std::string_view what) const;

  /// Decodes, prepares, smooths, measures, encodes; every stage timed and stoppable. Never throws.
  /// Errors: those of check(), decode(), pin_vertices(), encode(), and Cancelled, DeadlineExceeded,
  /// OutOfMemory, Internal.
  Result<SmoothResult> smooth(const SmoothJob& job, const RunControl& run) const;

  /// The error table of `mesh` against `reference`. Connectivity may differ; the measures that need it equal
  /// are then unset. Never throws. Errors: those of check(), decode(), Cancelled, DeadlineExceeded,
  /// OutOfMemory, Internal; those of a mesh say which ("reference: ...").
  Result<v1::CompareResponse> compare(const CompareJob& job, const RunControl& run) const;

  const RequestLimits& limits() const { return limits_; }

 private:
  RequestLimits limits_;
};

/// "0.1.0"
std::string_view version();

v1::ListMethodsResponse list_methods();

/// Protobuf JSON with zeros printed and parameters in alphabetical order; `compact` on one line.
std::string to_json(const google::protobuf::Message& message, bool compact);

/// Sets one parameter from text ("lambda", "0.5"), as query strings and --set give it. "iterations" too.
/// Errors: UnknownMethod, UnknownOption, BadOption.
Result<> set_parameter_from_text(v1::SmoothOptions& options, std::string_view name, std::string_view text);

v1::MeshFormat to_proto(Format format);
/// Unspecified gives nullopt.
std::optional<Format> from_proto(v1::MeshFormat format);

}  // namespace burnish
