// For who does not want to choose: looks at the mesh and runs what suits it.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

struct AutoParams {
  double strength = 1;  ///< 0 to 2: 0 leaves the mesh as it is, 1 takes away what looks like noise, 2 more
};

/// Estimates the noise; leaves a clean mesh as it is and smooths any other by `learned_normals`, the more
/// carefully the less noise there is. SmoothOutcome::choice says with which parameters, and why: asking for
/// them by name gives the same bytes. `iterations` of the options are the most stages. Errors: Cancelled,
/// DeadlineExceeded.
Result<SmoothOutcome> smooth_auto(Surface& surface, const AutoParams& params, const IterationOptions& options,
                                  const RunControl& run);

Method auto_method();

}  // namespace burnish
