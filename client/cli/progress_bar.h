// One line on a terminal that shows how far the work is.
#pragma once

#include <iosfwd>
#include <string>
#include <utility>

#include "burnish/v1/smoothing.pb.h"

namespace burnish::cli {

/// Draws "smoothing [######......] 42%" over itself, or "measuring ..." for a stage that does not tell how
/// far it is, and wipes it when destroyed. Draws only whole percents, so it costs nothing to call it often.
/// Not thread-safe.
class ProgressBar {
 public:
  /// `title` leads the line: "[3/12] scan.obj ".
  explicit ProgressBar(std::ostream& terminal, std::string title = {})
      : terminal_(terminal), title_(std::move(title)) {}
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(v1::SmoothStage stage, double fraction);  ///< fraction in [0, 1]

 private:
  std::ostream& terminal_;
  std::string title_;
  bool shown_ = false;
  v1::SmoothStage stage_ = v1::SMOOTH_STAGE_UNSPECIFIED;
  int percent_ = 0;
};

}  // namespace burnish::cli
