#include "client/cli/progress_bar.h"

#include <algorithm>
#include <ostream>
#include <string>

namespace burnish::cli {

ProgressBar::~ProgressBar() {
  if (percent_ >= 0) terminal_ << "\r\x1b[K" << std::flush;
}

void ProgressBar::show(double fraction) {
  const int percent = static_cast<int>(100 * std::clamp(fraction, 0.0, 1.0));
  if (percent == percent_) return;
  percent_ = percent;
  std::string bar(40, '.');
  std::fill_n(bar.begin(), bar.size() * static_cast<std::size_t>(percent) / 100, '#');
  terminal_ << "\rsmoothing [" << bar << "] " << percent << "% " << std::flush;
}

}  // namespace burnish::cli
