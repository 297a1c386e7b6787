// Results of the denoising benchmark as text, CSV and a picture.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace burnish::bench {

/// What a method reached on one pair. Ev/h is over the original's mean edge length.
struct Score {
  double ev = 0, degrees = 0, milliseconds = 0;
  std::string settings;
};

struct Outcome {
  std::string group;  ///< pairs of a group share a column, which shows their means
  std::string pair;
  std::string method;  ///< "noisy" for the input
  Score defaults;
  std::optional<Score> best_ev, best_degrees;  ///< of the sweep, each on its own
};

/// Markdown: per method and group the value with defaults, in brackets the best of the sweep.
void print_tables(const std::vector<Outcome>& outcomes);
/// Each outcome in a line, with the settings that were best. Names hold no commas.
bool write_csv(const std::vector<Outcome>& outcomes, const std::filesystem::path& path);
/// A panel per group: a bar per method for Ev/h with defaults, a tick for the best of the sweep, a line for
/// the noisy input.
bool write_svg(const std::vector<Outcome>& outcomes, const std::filesystem::path& path);

}  // namespace burnish::bench
