// For who does not want to choose: looks at the mesh and runs what suits it.
#pragma once

#include "core/smooth/iteration.h"
#include "core/smooth/registry.h"

namespace burnish {

struct AutoParams {
  double strength = 1;  ///< 0 to 2: 0 leaves the mesh as it is, 1 takes away what looks like noise, 2 more
};

/// What smooth_auto() is going to do.
struct AutoPlan {
  NoiseEstimate noise;
  MethodChoice choice;  ///< sharp_bending is 0, and the reason leaves out the surface below the noise: only
                        ///< smoothing shows it
};

/// Told from the noise alone, in a small part of the time of smoothing. Errors: Cancelled, DeadlineExceeded.
Result<AutoPlan> plan_auto(const Surface& surface, const AutoParams& params, const IterationOptions& options,
                           const RunControl& run);

/// Estimates the noise; leaves a clean mesh as it is and smooths any other by `learned_normals`, the more
/// carefully the less noise there is. SmoothOutcome::choice says with which parameters, and why: asking for
/// them by name gives the same bytes. `iterations` of the options are the most stages. Errors: Cancelled,
/// DeadlineExceeded.
Result<SmoothOutcome> smooth_auto(Surface& surface, const AutoParams& params, const IterationOptions& options,
                                  const RunControl& run);

Method auto_method();

}  // namespace burnish
