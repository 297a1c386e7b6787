// Which vertices stand out from a smoothing's moves.
#include "core/denoise/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/irregular.h"

namespace burnish {
namespace {

using testing::Random, testing::surface_of;

class FindOutliers : public ::testing::Test {
 protected:
  bool find() { return find_outliers(surface_.topology, movable_, moves_, outlier_, {}); }
  std::size_t count() const { return static_cast<std::size_t>(std::ranges::count(outlier_, 1)); }

  const Surface surface_ = surface_of(testing::sphere(5));
  const std::size_t size_ = surface_.mesh.positions.size();
  std::vector<std::uint8_t> movable_ = std::vector<std::uint8_t>(size_, 1), outlier_ = movable_;
  std::vector<float> moves_ = std::vector<float>(size_);
  Random random_{3};

  /// Small moves everywhere, as a smoothing makes of vertices that are right.
  void move_a_little(float most) {
    for (float& move : moves_) move = most * static_cast<float>(random_.unit());
  }
};

TEST_F(FindOutliers, FindsTheFewThatMoveFar) {
  move_a_little(0.1F);
  std::vector<std::size_t> far;
  for (std::size_t v = 7; v < size_; v += 20) far.push_back(v);
  for (const std::size_t v : far) moves_[v] = 1;
  ASSERT_TRUE(find());
  EXPECT_LT(count(), far.size() + size_ / 50);  // a few others do no harm
  for (const std::size_t v : far) EXPECT_EQ(outlier_[v], 1) << v;
}

TEST_F(FindOutliers, FindsNoneWhereAllMoveAlike) {
  move_a_little(1);
  EXPECT_FALSE(find());
  EXPECT_EQ(count(), 0U);
}

TEST_F(FindOutliers, FindsNoneWhereNothingMoves) {
  EXPECT_FALSE(find());
  EXPECT_EQ(count(), 0U);
}

/// The smoothing errs along a crease: all of it moves, and nothing there stands out.
TEST_F(FindOutliers, TakesNoneOfAWholeStripThatMoves) {
  move_a_little(0.01F);
  std::size_t in_strip = 0;
  for (std::size_t v = 0; v < size_; ++v) {
    if (std::abs(surface_.mesh.positions[v].z) > 0.15F) continue;
    moves_[v] = 0.9F + 0.1F * static_cast<float>(random_.unit());
    ++in_strip;
  }
  ASSERT_TRUE(find());
  EXPECT_LT(count(), in_strip / 10);
}

TEST_F(FindOutliers, NeverTakesAVertexThatMustNotMove) {
  move_a_little(0.1F);
  for (std::size_t v = 0; v < size_; v += 20) moves_[v] = 1;
  for (std::size_t v = 0; v < size_; v += 40) movable_[v] = 0;
  ASSERT_TRUE(find());
  for (std::size_t v = 0; v < size_; v += 40) EXPECT_EQ(outlier_[v], 0) << v;
  EXPECT_GT(count(), 0U);
}

}  // namespace
}  // namespace burnish
