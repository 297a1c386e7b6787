// Quantised positions: the grid of the input, what stays on it, and what it costs.
#include <algorithm>
#include <set>

#include "tests/core/draco_fixture.h"

namespace burnish::testing {
namespace {

TEST(DracoGrid, UnmovedPositionsComeBackBitIdentical) {
  for (const int bits : {0, 1, 8, 11, 14, 20, 23, 24, 25, 27, 30}) {
    for (const float offset : {0.0f, 17.3f, -1000.0f}) {
      SCOPED_TRACE(std::to_string(bits) + " bits around " + std::to_string(offset));
      auto mesh = seamed_sphere();
      place(*mesh, 1.7f, offset);
      const auto document = decoded(write_with_library(*mesh, {.position_bits = bits}));
      Moved moved(*document);
      // Towards the middle of the box, so that the grid still holds it.
      for (std::size_t v = 0; v < moved.after.size(); v += 3) moved.after[v] *= 0.5f;
      const auto encoded = document->encode_same(moved.view(), {}, kRun);
      ASSERT_TRUE(encoded.ok());
      EXPECT_TRUE(encoded->warnings.empty());
      EXPECT_EQ(encoded->position_bits, bits);
      const auto again = decoded(encoded->bytes);
      ASSERT_EQ(again->positions().size(), document->positions().size());
      EXPECT_TRUE(std::ranges::equal(again->triangles(), document->triangles()));
      const MovedPositions view = moved.view();
      double largest = 0;
      for (Index p = 0; p < again->positions().size(); ++p) {
        if (!view.moved(p)) {
          ASSERT_EQ(again->positions()[p], document->positions()[p]) << p;
        }
        largest = std::max(largest, length(again->positions()[p] - view.at(p)));
      }
      EXPECT_EQ(encoded->quantisation_error, largest);
    }
  }
}

TEST(DracoGrid, ValuesThatPointsShareComeBackFromTheFinestGrids) {
  const auto sorted = [](const Document& document) {
    std::multiset<std::array<double, 3>> all;
    for (const Vec3d& p : document.positions()) all.insert({p.x, p.y, p.z});
    return all;
  };
  for (const int bits : {23, 24, 27, 30}) {
    for (const float scale : {1.0f, 1.3f, 1.7f, 2.9f}) {
      auto mesh = seamed_sphere();
      place(*mesh, scale, 0.4f);
      const auto document =
          decoded(write_with_library(*mesh, {.method = DracoMethod::Edgebreaker, .position_bits = bits}));
      const auto encoded = document->encode_same(Moved(*document).view(), {}, kRun);
      ASSERT_TRUE(encoded.ok());
      EXPECT_EQ(encoded->quantisation_error, 0) << bits;
      EXPECT_EQ(sorted(*decoded(encoded->bytes)), sorted(*document)) << bits << " bits, scale " << scale;
    }
  }
}

TEST(DracoGrid, StatedQuantisationErrorBoundsEdgebreakerToo) {
  const std::string bytes =
      write_with_library(*seamed_sphere(), {.method = DracoMethod::Edgebreaker, .position_bits = 9});
  const auto document = decoded(bytes);
  Moved moved(*document);
  for (Vec3f& p : moved.after) p *= 0.9f;
  const auto encoded = document->encode_same(moved.view(), {}, kRun);
  ASSERT_TRUE(encoded.ok());
  EXPECT_GT(encoded->quantisation_error, 0);
  EXPECT_LT(encoded->quantisation_error, 2.0 / 511);
  double largest = 0;
  const auto again = decoded(encoded->bytes);
  for (const Vec3d& p : again->positions()) {
    double nearest = 1e9;
    for (Index v = 0; v < document->positions().size(); ++v) {
      nearest = std::min(nearest, length(p - moved.view().at(v)));
    }
    largest = std::max(largest, nearest);
  }
  EXPECT_LE(largest, encoded->quantisation_error);
  ASSERT_EQ(encoded->warnings.size(), 1u);
  EXPECT_EQ(encoded->warnings[0].code, "order_not_kept");
}

TEST(DracoGrid, GridOfATinyMeshIsKeptToTheLastBit) {
  // The library's own way to pass a grid keeps six decimals.
  auto mesh = seamed_sphere();
  place(*mesh, 3.3e-6f, 0);
  const auto document = decoded(write_with_library(*mesh, {.position_bits = 12}));
  const auto encoded = document->encode_same(Moved(*document).view(), {}, kRun);
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->position_bits, 12);
  EXPECT_TRUE(std::ranges::equal(decoded(encoded->bytes)->positions(), document->positions()));
}

TEST(DracoGrid, VertexBeyondTheGridWidensItByWholeCells) {
  const auto document = decoded(write_with_library(*seamed_sphere(), {.position_bits = 10}));
  Moved moved(*document);
  moved.after[5] *= 1.9f;
  const auto encoded = document->encode_same(moved.view(), {}, kRun);
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->position_bits, 11);
  ASSERT_EQ(encoded->warnings.size(), 1u);
  EXPECT_EQ(encoded->warnings[0].code, "quantisation_grid_widened");
  EXPECT_EQ(encoded->warnings[0].count, 1u);
  const double cell = 2.0 / 1023;
  EXPECT_LE(encoded->quantisation_error, 0.87 * cell);
  const auto again = decoded(encoded->bytes);
  for (Index p = 0; p < again->positions().size(); ++p) {
    EXPECT_LE(length(again->positions()[p] - moved.view().at(p)), encoded->quantisation_error);
    // The cells are where they were: those that did not move are off by rounding, not by parts of a cell.
    if (!moved.view().moved(p)) {
      EXPECT_LE(length(again->positions()[p] - document->positions()[p]), 1e-3 * cell);
    }
  }
}

TEST(DracoGrid, GridFarTooSmallScalesAtThirtyBits) {
  const auto document = decoded(write_with_library(*seamed_sphere(), {.position_bits = 28}));
  Moved moved(*document);
  moved.after[5] *= 1000.0f;
  const auto encoded = document->encode_same(moved.view(), {}, kRun);
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->position_bits, 30);
  EXPECT_EQ(encoded->warnings.at(0).code, "quantisation_grid_widened");
  const auto again = decoded(encoded->bytes);
  EXPECT_LE(length(again->positions()[5] - moved.view().at(5)), encoded->quantisation_error);
}

}  // namespace
}  // namespace burnish::testing
