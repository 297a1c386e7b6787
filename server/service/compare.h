// Measuring one mesh against another, without smoothing.
#pragma once

#include <optional>
#include <string_view>

#include "burnish/v1/smoothing.pb.h"
#include "core/io/codec.h"
#include "core/run/run_control.h"

namespace burnish {

/// The error table of `mesh` against `reference` (errors.against is "reference"). Connectivity may differ;
/// the measures that need it equal are then unset. Errors: as decode().
Result<v1::MeshErrors> compare_meshes(std::string_view reference, std::string_view mesh, const Limits& limits,
                                      const RunControl& run);

}  // namespace burnish
