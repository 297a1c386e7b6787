// Fields of normals, patch by patch.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/denoise/normal_patches.h"
#include "core/smooth/adaptive.h"
#include "core/smooth/learned_normals.h"
#include "tests/support/irregular.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using testing::surface_of;

std::vector<SimdVec3> positions_of(const Surface& surface) {
  return {surface.mesh.positions.begin(), surface.mesh.positions.end()};
}

/// What the networks see of a face.
using Seen = std::array<float, NormalFields::kInputs>;

/// Of each face.
std::vector<Seen> inputs(const Surface& surface, std::size_t most_faces,
                         std::size_t together = NormalFields::kTogether) {
  const RunControl run;
  const Faces faces(surface, FaceNeighbourhood::Vertices, run);
  NormalPatches patches(surface, faces, run, most_faces);
  std::vector<Seen> result(faces.size());
  std::size_t seen = 0;
  const bool done = patches.measure(positions_of(surface), [&](const NormalFields& fields) {
    NormalFields::Inputs described;
    for (std::size_t first = 0; first < fields.size(); first += together) {
      const std::size_t count = std::min(together, fields.size() - first);
      fields.describe(first, count, patches.whole(), described);
      for (std::size_t lane = 0; lane < count; ++lane) {
        Seen& of_face = result[fields.number(first + lane)];
        for (std::size_t i = 0; i < of_face.size(); ++i) of_face[i] = described[i][lane];
      }
      seen += count;
    }
    return true;
  });
  EXPECT_TRUE(done);
  EXPECT_EQ(seen, faces.size());
  return result;
}

TEST(NormalPatches, GiveTheSameNumbersHoweverTheMeshIsParted) {
  for (const auto& shape : {testing::grid(60), testing::sphere(5), testing::cube(20)}) {
    const Surface surface = surface_of(testing::with_noise(shape, 0.2));
    const auto whole = inputs(surface, surface.mesh.triangles.size());
    EXPECT_EQ(inputs(surface, 1000), whole);
    EXPECT_EQ(inputs(surface, 777), whole);
  }
}

TEST(NormalPatches, GiveTheSameNumbersHoweverManyFacesAreDescribedTogether) {
  const Surface surface = surface_of(testing::with_noise(testing::cube(5), 0.2));
  const auto by_eights = inputs(surface, surface.mesh.triangles.size());
  for (const std::size_t together : {1, 3, 7})
    EXPECT_EQ(inputs(surface, surface.mesh.triangles.size(), together), by_eights);
}

/// A cone of so many triangles, and one more at its rim.
testing::Shape fan(Index triangles) {
  testing::Shape shape;
  shape.positions.push_back({0, 0, 0.5});
  for (Index i = 0; i < triangles; ++i) {
    const double angle = 6.283185307179586 * i / triangles;
    shape.positions.push_back({std::cos(angle), std::sin(angle), 0.01 * (i % 7)});
    shape.triangles.push_back({0, 1 + i, 1 + (i + 1) % triangles});
  }
  shape.positions.push_back({2, 0, 0});
  shape.triangles.push_back({1, static_cast<Index>(triangles + 1), 2});
  return shape;
}

TEST(Faces, OfAFanAreNeighboursOfAllOfItUnlessThatIsACrowd) {
  for (const Index triangles : {Index{100}, Index{5000}}) {
    const Surface surface = surface_of(fan(triangles));
    const Faces faces(surface, FaceNeighbourhood::Vertices, {});
    std::vector<std::multiset<Index>> neighbours(faces.size());
    for (Index f = 0; f < faces.size(); ++f) {
      faces.for_each_neighbour(f, [&](Index n) { neighbours[f].insert(n); });
    }
    // The triangle at the rim touches the one across its edge and the two beside that.
    EXPECT_EQ(neighbours[triangles].size(), 3U);
    EXPECT_EQ(neighbours[triangles / 2].size(), triangles == 100 ? 99U : 2U);
    EXPECT_EQ(neighbours[0].size(), triangles == 100 ? 100U : 3U);
    for (Index f = 0; f < faces.size(); ++f) {
      for (const Index n : neighbours[f]) {
        EXPECT_EQ(neighbours[f].count(n), 1U);
        EXPECT_EQ(neighbours[n].count(f), 1U) << n << " and " << f;
      }
    }
  }
}

/// n^2 pairs of neighbours would be minutes, and more bytes than there are.
TEST(Faces, OfAFanOfAHundredThousandAreSmoothedAtOnce) {
  const AdaptiveParams by_vertices{.neighbourhood = AdaptiveParams::Neighbourhood::Vertices};
  Surface learned = surface_of(fan(100'000)), adaptive = learned;
  const auto before = learned.mesh.positions;
  ASSERT_TRUE(smooth_learned_normals(learned, {}, {.iterations = 1}, {}));
  EXPECT_FALSE(learned.mesh.positions == before);
  ASSERT_TRUE(smooth_adaptive(adaptive, by_vertices, {.iterations = 3}, {}));
  EXPECT_FALSE(adaptive.mesh.positions == before);
}

}  // namespace
}  // namespace burnish
