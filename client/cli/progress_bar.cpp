#include "client/cli/progress_bar.h"

#include <algorithm>
#include <ostream>
#include <string>

namespace burnish::cli {
namespace {

constexpr const char* kWipe = "\r\x1b[K";

const char* label(v1::SmoothStage stage) {
  switch (stage) {
    case v1::SMOOTH_STAGE_QUEUE:
      return "waiting";
    case v1::SMOOTH_STAGE_DECODE:
      return "decoding";
    case v1::SMOOTH_STAGE_PREPARE:
      return "preparing";
    case v1::SMOOTH_STAGE_SMOOTH:
      return "smoothing";
    case v1::SMOOTH_STAGE_MEASURE:
      return "measuring";
    case v1::SMOOTH_STAGE_ENCODE:
      return "encoding";
    default:
      return "working";
  }
}

std::string bar(int percent) {
  std::string cells(40, '.');
  std::fill_n(cells.begin(), cells.size() * static_cast<std::size_t>(percent) / 100, '#');
  return "[" + cells + "] " + std::to_string(percent) + "%";
}

}  // namespace

ProgressBar::~ProgressBar() {
  if (shown_) terminal_ << kWipe << std::flush;
}

void ProgressBar::show(v1::SmoothStage stage, double fraction) {
  const int percent = static_cast<int>(100 * std::clamp(fraction, 0.0, 1.0));
  if (shown_ && stage == stage_ && percent == percent_) return;
  shown_ = true;
  stage_ = stage;
  percent_ = percent;
  const bool tells = stage == v1::SMOOTH_STAGE_SMOOTH || percent > 0;
  terminal_ << kWipe << title_ << label(stage) << " " << (tells ? bar(percent) : "...") << std::flush;
}

}  // namespace burnish::cli
