// Decimal text of coordinates, with the digits that they are worth.
#pragma once

#include <string>

#include "core/mesh/mesh.h"

namespace burnish {

/// Writes numbers with a fixed count of decimals; those that do not fit exactly as the shortest text that
/// reads back to the same double. Immutable.
class DecimalWriter {
 public:
  /// For a mesh: enough decimals to resolve the last bit of a local float (2^-24 of the frame's unit), so
  /// that writing and reading again moves no coordinate by more than half of that.
  explicit DecimalWriter(const Frame& frame);
  /// 0 to 15 decimals; any other number: always the shortest text.
  explicit DecimalWriter(int decimals);

  void append(std::string& out, double value) const;
  void append(std::string& out, const Vec3d& v) const;  ///< "x y z"

  /// Largest distance between a point and its text, for numbers that fit.
  double largest_error() const;

 private:
  char* write(char* to, double value) const;  // returns the end

  int decimals_;      // negative: shortest
  double power_ = 1;  // 10^decimals_
};

}  // namespace burnish
