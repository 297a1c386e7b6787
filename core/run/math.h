// Elementary functions with the same bits on every x86-64 processor. The C library picks variants by
// processor (with and without fused multiply-add), so exp and atan2 from there would make meshes differ
// between machines.
#pragma once

#include <bit>
#include <cstdint>

namespace burnish {

/// e^x for x in [-700, 700] (clamped outside), relative error below 1e-15.
double portable_exp(double x);

/// Four floats in one register.
using FourFloats = float __attribute__((vector_size(16)));

/// e^x in each lane for x in [-87, 88] (clamped outside), relative error below 3e-7. Several times as fast as
/// the other.
inline FourFloats portable_exp(FourFloats x) {
  using FourInts = std::int32_t __attribute__((vector_size(16)));
  constexpr float kLog2E = 1.44269504F, kRound = 0x1.8p23F;
  constexpr float kLn2High = 0.693145752F, kLn2Low = 1.42860677e-6F;  // high has 15 bits: k * high is exact
  constexpr float kTerms[] = {1.0F / 5040, 1.0F / 720, 1.0F / 120, 1.0F / 24, 1.0F / 6, 0.5F, 1.0F, 1.0F};
  constexpr FourFloats kLeast = {-87, -87, -87, -87}, kMost = {88, 88, 88, 88};
  x = x < kLeast ? kLeast : x;
  x = x > kMost ? kMost : x;
  const FourFloats k = (x * kLog2E + kRound) - kRound;
  const FourFloats r = (x - k * kLn2High) - k * kLn2Low;  // |r| <= ln(2) / 2
  FourFloats sum = r * kTerms[0] + kTerms[1];
  for (int n = 2; n < 8; ++n) sum = sum * r + kTerms[n];
  const FourInts power = (__builtin_convertvector(k, FourInts) + 127) << 23;
  return sum * std::bit_cast<FourFloats>(power);
}

/// Angle in [0, pi] whose tangent is y/x, for y >= 0; 0 when both are 0. Absolute error below 1e-15.
double portable_angle(double y, double x);

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegreesPerRadian = 180.0 / kPi;

/// atan(i / 16), for portable_angle() and its twin on vectors (core/measure/triangle_sums.cpp).
inline constexpr double kArctangents[] = {0.0,
                                          0.06241880999595735,
                                          0.12435499454676144,
                                          0.18534794999569476,
                                          0.24497866312686414,
                                          0.3028848683749714,
                                          0.35877067027057225,
                                          0.4124104415973873,
                                          0.4636476090008061,
                                          0.5123894603107377,
                                          0.5585993153435624,
                                          0.6022873461349642,
                                          0.6435011087932844,
                                          0.6823165548747481,
                                          0.7188299996216245,
                                          0.7531512809621944,
                                          0.7853981633974483};

/// Cosine of x in [-1e6, 1e6] radians, absolute error below 1e-15.
double portable_cos(double x);

}  // namespace burnish
