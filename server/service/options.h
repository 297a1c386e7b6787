// From the contract's options to what core takes.
#pragma once

#include "burnish/v1/smoothing.pb.h"
#include "core/io/codec.h"
#include "core/io/pins.h"
#include "core/smooth/registry.h"

namespace burnish {

struct ResolvedOptions {
  const Method* method = nullptr;
  ParameterValues parameters;  ///< every one of the method's, in range
  OutputOptions output;
  PinOptions pinned;  ///< the mesh may not have what it names
};

/// Errors: UnknownMethod, UnknownOption, BadOption; Error::field names the option ("lambda",
/// "output.draco.position_bits").
Result<ResolvedOptions> resolve_options(const v1::SmoothOptions& options);

google::protobuf::Value to_proto(const ParameterValue& value);

}  // namespace burnish
