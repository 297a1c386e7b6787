#include "core/run/math.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace burnish {
namespace {

/// 1/0! to 1/13!, the series of e^x: constants, because a division per term would be most of the cost.
constexpr auto kInverseFactorials = [] {
  std::array<double, 14> inverse{};
  double factorial = 1;
  for (std::size_t n = 0; n < inverse.size(); ++n) {
    inverse[n] = 1 / factorial;
    factorial *= static_cast<double>(n + 1);
  }
  return inverse;
}();

// Three halvings bring the argument below tan(pi/32), where nine terms of the series reach double accuracy.
double arctangent_up_to_one(double t) {
  for (int i = 0; i < 3; ++i) t = t / (1.0 + std::sqrt(1.0 + t * t));
  const double s = t * t;
  double sum = 0;
  for (int k = 17; k >= 1; k -= 2) sum = 1.0 / k - s * sum;
  return 8.0 * t * sum;
}

}  // namespace

double portable_exp(double x) {
  constexpr double kLog2E = 1.44269504088896340736;
  constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
  constexpr double kRound = 0x1.8p52;  // adding and taking it away again rounds to a whole number
  x = std::clamp(x, -700.0, 700.0);
  const double k = (x * kLog2E + kRound) - kRound;
  const double r = (x - k * kLn2High) - k * kLn2Low;  // |r| <= ln(2) / 2
  double sum = kInverseFactorials.back();
  for (std::size_t n = kInverseFactorials.size() - 1; n-- > 0;) sum = kInverseFactorials[n] + r * sum;
  const auto power = static_cast<std::uint64_t>(static_cast<std::int64_t>(k) + 1023) << 52;
  return sum * std::bit_cast<double>(power);
}

double portable_angle(double y, double x) {
  const double size = std::abs(x);
  if (y == 0 && size == 0) return 0;
  const double acute = y <= size ? arctangent_up_to_one(y / size) : kPi / 2 - arctangent_up_to_one(size / y);
  return x < 0 ? kPi - acute : acute;
}

}  // namespace burnish
