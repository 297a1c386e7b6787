#include "core/io/text_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace burnish {
namespace {

std::string text(const DecimalWriter& writer, double value) {
  std::string out;
  writer.append(out, value);
  return out;
}

TEST(DecimalWriter, WritesFixedDecimals) {
  const DecimalWriter three(3);
  EXPECT_EQ(text(three, 1.23456), "1.235");
  EXPECT_EQ(text(three, -0.5), "-0.500");
  EXPECT_EQ(text(three, 0.0004), "0.000");
  EXPECT_EQ(text(three, -0.0004), "0.000");  // never a negative zero
  EXPECT_EQ(text(three, 1234567), "1234567.000");
  EXPECT_EQ(text(DecimalWriter(0), 41.7), "42");
}

TEST(DecimalWriter, FallsBackToTheShortestExactText) {
  EXPECT_EQ(text(DecimalWriter(-1), 0.1), "0.1");
  EXPECT_EQ(text(DecimalWriter(16), 0.25), "0.25");
  EXPECT_EQ(std::strtod(text(DecimalWriter(3), 1.2345e40).c_str(), nullptr), 1.2345e40);
}

TEST(DecimalWriter, ResolvesTheLastBitOfALocalFloat) {
  std::mt19937_64 random(3);
  for (const int exponent : {-30, -7, 0, 9, 40}) {
    const Frame frame{{}, exponent};
    const DecimalWriter writer(frame);
    for (int i = 0; i < 200; ++i) {
      const double value = std::ldexp(static_cast<double>(random() >> 11) * 0x1p-53 - 0.5, exponent);
      const double read = std::strtod(text(writer, value).c_str(), nullptr);
      EXPECT_LE(std::abs(read - value), frame.scale() * 0x1p-25 + std::abs(value) * 0x1p-52) << value;
    }
    EXPECT_LE(writer.largest_error(), frame.scale() * 0x1p-24);
  }
}

}  // namespace
}  // namespace burnish
