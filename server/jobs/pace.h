// How fast jobs run here, learned from those that ran.
#pragma once

#include <chrono>
#include <optional>

namespace burnish {

/// Seconds per unit of work, averaged over the last few jobs. Not thread-safe.
class Pace {
 public:
  void learn(double work, std::chrono::duration<double> took);

  /// Expected run time; nothing before the first job ran.
  std::optional<std::chrono::duration<double>> expect(double work) const;

 private:
  double seconds_per_work_ = 0;
  bool known_ = false;
};

}  // namespace burnish
