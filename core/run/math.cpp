#include "core/run/math.h"

#include <algorithm>
#include <cmath>

namespace burnish {
namespace {

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
  x = std::clamp(x, -700.0, 700.0);
  const double k = std::floor(x * kLog2E + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;  // |r| <= ln(2) / 2
  double sum = 1.0;
  for (int n = 14; n >= 1; --n) sum = 1.0 + r * sum / n;
  return std::ldexp(sum, static_cast<int>(k));
}

double portable_angle(double y, double x) {
  const double size = std::abs(x);
  if (y == 0 && size == 0) return 0;
  const double acute = y <= size ? arctangent_up_to_one(y / size) : kPi / 2 - arctangent_up_to_one(size / y);
  return x < 0 ? kPi - acute : acute;
}

}  // namespace burnish
