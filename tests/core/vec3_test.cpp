#include "core/mesh/vec3.h"

#include <gtest/gtest.h>

namespace burnish {
namespace {

// noipa: with the arguments known, GCC folds the call and rounds rightly.
[[gnu::noipa]] Vec3d through_float(const Vec3d& p) {
  const Vec3f rounded = to_float(p);
  return to_double(rounded);
}

// GCC 12's SLP vectoriser gives p itself back at -O2: positions compared in double are then not the ones
// stored.
TEST(Vec3, RoundsWhenItGoesThroughFloat) {
  const Vec3d p{0.1, 0.2, 0.3}, q = through_float(p);
  EXPECT_EQ(q.x, static_cast<double>(0.1F));
  EXPECT_EQ(q.y, static_cast<double>(0.2F));
  EXPECT_EQ(q.z, static_cast<double>(0.3F));
}

TEST(Vec3, CrossIsRightHanded) { EXPECT_EQ(cross(Vec3d{1, 0, 0}, Vec3d{0, 1, 0}), (Vec3d{0, 0, 1})); }

}  // namespace
}  // namespace burnish
