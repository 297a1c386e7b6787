#include "core/run/math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

TEST(PortableExp, OfFourFloatsAgreesWithTheLibraryToSixDigits) {
  for (float x = -86.9F; x < 87.9F; x += 0.0137F) {
    const FourFloats four = portable_exp(FourFloats{x, 0, -1e30F, 1e30F});
    EXPECT_NEAR(static_cast<double>(four[0]) / std::exp(static_cast<double>(x)), 1, 3e-7) << x;
    EXPECT_EQ(four[1], 1);
    EXPECT_GT(four[2], 0);
    EXPECT_TRUE(std::isfinite(four[3]));
  }
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

TEST(PortableCos, AgreesWithTheLibraryAllAround) {
  for (double x = -20; x < 20; x += 0.00137) EXPECT_NEAR(portable_cos(x), std::cos(x), 1e-15) << x;
  for (double x = -1e6; x < 1e6; x += 1234.567) EXPECT_NEAR(portable_cos(x), std::cos(x), 1e-15) << x;
}

TEST(PortableCos, KnowsItsCorners) {
  EXPECT_EQ(portable_cos(0), 1);
  EXPECT_EQ(portable_cos(kPi), -1);
  EXPECT_NEAR(portable_cos(kPi / 2), 0, 1e-16);
  EXPECT_EQ(portable_cos(-2), portable_cos(2));
}

TEST(PortableMath, AnswersNoNumberWithNoNumber) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN(),
                   kFar = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(portable_exp(kNone)));
  EXPECT_TRUE(std::isnan(portable_angle(kNone, 1)));
  EXPECT_TRUE(std::isnan(portable_angle(1, kNone)));
  EXPECT_TRUE(std::isnan(portable_angle(kFar, kFar)));
}

}  // namespace
}  // namespace burnish
