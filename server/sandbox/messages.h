// Limits and errors as burnishd and its helpers send them.
#pragma once

#include "sandbox/sandbox.pb.h"
#include "server/service/limits.h"

namespace burnish {

inline RequestLimits limits_of(const sandbox::Setup& setup) {
  return {.mesh = {.max_bytes = setup.max_bytes(),
                   .max_vertices = setup.max_vertices(),
                   .max_triangles = setup.max_triangles(),
                   .max_attributes = setup.max_attributes(),
                   .max_line_bytes = setup.max_line_bytes()},
          .max_iterations = setup.max_iterations(),
          .max_option_bytes = setup.max_option_bytes()};
}

inline sandbox::Setup setup_of(const RequestLimits& limits, std::uint64_t max_memory) {
  sandbox::Setup setup;
  setup.set_max_bytes(limits.mesh.max_bytes);
  setup.set_max_vertices(limits.mesh.max_vertices);
  setup.set_max_triangles(limits.mesh.max_triangles);
  setup.set_max_attributes(limits.mesh.max_attributes);
  setup.set_max_line_bytes(limits.mesh.max_line_bytes);
  setup.set_max_iterations(limits.max_iterations);
  setup.set_max_option_bytes(limits.max_option_bytes);
  setup.set_max_memory(max_memory);
  return setup;
}

inline void set_failure(const Error& error, sandbox::Failure& failure) {
  failure.set_cause(static_cast<std::uint32_t>(error.cause));
  failure.set_message(error.message);
  failure.set_field(error.field);
}

/// A cause that does not exist is Internal.
inline Error error_of(const sandbox::Failure& failure) {
  Error error{Cause::Internal, failure.message(), failure.field()};
  for (const Cause cause : all_causes()) {
    if (static_cast<std::uint32_t>(cause) == failure.cause()) error.cause = cause;
  }
  return error;
}

}  // namespace burnish
