// The helper process: smooths and compares what burnishd hands it, with no right to do anything else.
#pragma once

#include "server/service/smooth_service.h"

namespace burnish {

/// Open in every helper as it starts: the sockets for jobs and for cancelling them, and the buffers of what
/// comes and of what goes.
constexpr int kHelperJobs = 3, kHelperCancels = 4, kHelperInput = 5, kHelperOutput = 6;
/// The only argument of a helper's program.
constexpr const char* kHelperArgument = "sandbox-helper";

/// Works until burnishd is gone; the exit code of the process. `smooth` stands in for the service's in tests.
int run_helper(SmoothFunction smooth = {});

}  // namespace burnish
