#include "core/run/math.h"

#include <gtest/gtest.h>

#include <cmath>

namespace burnish {
namespace {

TEST(PortableExp, AgreesWithTheLibraryToFifteenDigits) {
  for (double x = -690; x < 690; x += 0.37) EXPECT_NEAR(portable_exp(x) / std::exp(x), 1, 4e-15) << x;
  EXPECT_EQ(portable_exp(0), 1);
}

TEST(PortableExp, StaysFiniteOutsideItsRange) {
  EXPECT_TRUE(std::isfinite(portable_exp(1e308)));
  EXPECT_GT(portable_exp(-1e308), 0);
}

TEST(PortableAngle, AgreesWithTheLibraryAllAround) {
  for (double angle = 0; angle <= kPi; angle += 0.001) {
    EXPECT_NEAR(portable_angle(std::sin(angle), std::cos(angle)), angle, 2e-15) << angle;
  }
  EXPECT_NEAR(portable_angle(1e-200, 1), 1e-200, 1e-215);
}

TEST(PortableAngle, KnowsItsCorners) {
  EXPECT_EQ(portable_angle(0, 0), 0);
  EXPECT_EQ(portable_angle(0, 3), 0);
  EXPECT_DOUBLE_EQ(portable_angle(0, -3), kPi);
  EXPECT_DOUBLE_EQ(portable_angle(2, 0), kPi / 2);
}

}  // namespace
}  // namespace burnish
