// A Vec3f in one 16-byte register: what the inner loops gather and add. Arithmetic is that of Vec3f, in its
// order, so results are the same bits; only the speed differs (measured in
// docs/decisions/0008-vectors-in-registers.md).
#pragma once

#include <span>
#include <vector>

#include "core/mesh/vec3.h"

namespace burnish {

class SimdVec3 {
 public:
  using Lanes = float __attribute__((vector_size(16)));

  constexpr SimdVec3() = default;
  explicit constexpr SimdVec3(Lanes lanes) : lanes_(lanes) {}
  constexpr SimdVec3(float x, float y, float z) : lanes_{x, y, z, 0} {}
  explicit constexpr SimdVec3(const Vec3f& a) : lanes_{a.x, a.y, a.z, 0} {}
  Vec3f vec3() const { return {lanes_[0], lanes_[1], lanes_[2]}; }
  Lanes lanes() const { return lanes_; }

  float x() const { return lanes_[0]; }
  float y() const { return lanes_[1]; }
  float z() const { return lanes_[2]; }

  SimdVec3& operator+=(SimdVec3 b) { return lanes_ += b.lanes_, *this; }
  SimdVec3& operator-=(SimdVec3 b) { return lanes_ -= b.lanes_, *this; }
  friend SimdVec3 operator+(SimdVec3 a, SimdVec3 b) { return SimdVec3(a.lanes_ + b.lanes_); }
  friend SimdVec3 operator-(SimdVec3 a, SimdVec3 b) { return SimdVec3(a.lanes_ - b.lanes_); }
  friend SimdVec3 operator*(SimdVec3 a, float s) { return SimdVec3(a.lanes_ * s); }

  friend float dot(SimdVec3 a, SimdVec3 b) {
    const Lanes products = a.lanes_ * b.lanes_;
    return products[0] + products[1] + products[2];
  }
  friend SimdVec3 cross(SimdVec3 a, SimdVec3 b) {
    const Lanes left = a.turned() * b.turned_back(), right = a.turned_back() * b.turned();
    return SimdVec3(left - right);
  }
  friend float length(SimdVec3 a) { return std::sqrt(dot(a, a)); }

 private:
  // The fourth lane stays 0, or -0.
  Lanes turned() const { return __builtin_shufflevector(lanes_, lanes_, 1, 2, 0, 3); }
  Lanes turned_back() const { return __builtin_shufflevector(lanes_, lanes_, 2, 0, 1, 3); }

  Lanes lanes_{};
};

/// Four points, a row each, by axis.
[[gnu::always_inline]] inline void by_axis(const SimdVec3::Lanes (&rows)[4], SimdVec3::Lanes (&axes)[3]) {
  const SimdVec3::Lanes xy01 = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5),
                        xy23 = __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5),
                        z01 = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7),
                        z23 = __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7);
  axes[0] = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5);
  axes[1] = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7);
  axes[2] = __builtin_shufflevector(z01, z23, 0, 1, 4, 5);
}

}  // namespace burnish
