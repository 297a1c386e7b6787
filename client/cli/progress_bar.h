// One line on a terminal that shows how far the work is.
#pragma once

#include <iosfwd>

namespace burnish::cli {

/// Draws "smoothing [######......]  42%" over itself and wipes it when destroyed. Draws only whole percents,
/// so it costs nothing to call it often. Not thread-safe.
class ProgressBar {
 public:
  explicit ProgressBar(std::ostream& terminal) : terminal_(terminal) {}
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(double fraction);  ///< in [0, 1]

 private:
  std::ostream& terminal_;
  int percent_ = -1;
};

}  // namespace burnish::cli
