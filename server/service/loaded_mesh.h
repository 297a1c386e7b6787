// The first stages of every request, smoothing or comparing: bytes to a surface, each stage timed.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "burnish/v1/smoothing.pb.h"
#include "core/io/codec.h"
#include "core/mesh/surface.h"
#include "core/run/run_control.h"

namespace burnish {

class Stopwatch {
 public:
  /// Milliseconds since the last call, or since construction.
  double lap();

 private:
  RunControl::Clock::time_point start_ = RunControl::Clock::now();
};

struct LoadedMesh {
  std::unique_ptr<Document> document;
  Surface surface;

  void summarise(v1::MeshSummary& summary) const;
  std::vector<Warning> warnings() const;  ///< what is unusual about the surface
};

/// Decodes and prepares, adding to decode_ms and prepare_ms of `timings`. `bytes` must outlive the result.
/// Errors: those of decode() and prepare_surface(), led by `what` ("reference: ", or nothing).
Result<LoadedMesh> load_mesh(std::string_view bytes, std::optional<Format> format, std::string_view what,
                             const Limits& limits, const RunControl& run, v1::StageTimings& timings);

void add_warnings(const std::vector<Warning>& warnings,
                  google::protobuf::RepeatedPtrField<v1::ReportWarning>& out);

}  // namespace burnish
