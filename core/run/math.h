// Elementary functions with the same bits on every x86-64 processor. The C library picks variants by
// processor (with and without fused multiply-add), so exp and atan2 from there would make meshes differ
// between machines.
#pragma once

namespace burnish {

/// e^x for x in [-700, 700] (clamped outside), relative error below 1e-15.
double portable_exp(double x);

/// Angle in [0, pi] whose tangent is y/x, for y >= 0; 0 when both are 0. Absolute error below 1e-15.
double portable_angle(double y, double x);

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegreesPerRadian = 180.0 / kPi;

}  // namespace burnish
