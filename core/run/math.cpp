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

// The nearest sixteenth takes most of the angle; of the rest, below 1/32, six terms of the series reach
// double accuracy.
double arctangent_up_to_one(double t) {
  if (std::isnan(t)) return t;  // of two infinities: it has no place in the table
  const auto nearest = static_cast<std::size_t>((t * 32 + 1) / 2);
  const double sixteenths = static_cast<double>(nearest) / 16;
  const double rest = (t - sixteenths) / (1 + t * sixteenths), s = rest * rest;
  double sum = 0;
  for (int k = 11; k >= 1; k -= 2) sum = 1.0 / k - s * sum;
  return kArctangents[nearest] + rest * sum;
}

}  // namespace

double portable_exp(double x) {
  constexpr double kLog2E = 1.44269504088896340736;
  constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
  constexpr double kRound = 0x1.8p52;  // adding and taking it away again rounds to a whole number
  if (std::isnan(x)) return x;         // no whole number is near it
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

double portable_cos(double x) {
  constexpr double kHalfPiHigh = 0x1.921fb544p0, kHalfPiMiddle = 0x1.0b46118p-34,
                   kHalfPiLow = 0x1.313198a2e037p-61;
  constexpr double kRound = 0x1.8p52;
  const double quarters = (x * (2 / kPi) + kRound) - kRound;
  const double r = ((x - quarters * kHalfPiHigh) - quarters * kHalfPiMiddle) - quarters * kHalfPiLow;
  const auto quadrant = static_cast<std::int64_t>(quarters) & 3;
  const bool odd = (quadrant & 1) != 0;  // a sine: the series starts a power later
  double sum = 0;
  for (int n = odd ? 19 : 18; n > 1; n -= 2) sum = (1 - sum) * (r * r) / (n * (n - 1));
  const double value = odd ? r * (1 - sum) : 1 - sum;
  return quadrant == 1 || quadrant == 2 ? -value : value;
}

}  // namespace burnish
