// What may change the order of work and must not change anything else: sorting a mesh in memory, groups of
// equal valence, wide vectors.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/mesh/order.h"
#include "core/shape/noise.h"
#include "core/smooth/adaptive_kernels.h"
#include "core/smooth/registry.h"
#include "core/smooth/valence_order.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace burnish::testing;

/// A mesh large enough to be sorted, in the worst order.
Shape scattered() {
  Shape shape = with_noise(sphere(5), 0.005);
  shape = with_vertex_order(shape, shuffled(shape.positions.size()));
  const auto order = shuffled(shape.triangles.size());
  Shape result = shape;
  for (std::size_t t = 0; t < order.size(); ++t) result.triangles[order[t]] = shape.triangles[t];
  return result;
}

double mean_span(const Surface& surface) {
  double sum = 0;
  for (const Triangle& t : surface.mesh.triangles) {
    const auto [low, high] = std::minmax({t[0], t[1], t[2]});
    sum += high - low;
  }
  return sum / static_cast<double>(surface.mesh.triangles.size());
}

TEST(OrderForCache, SortsAMeshThatJumpsAbout) {
  const Surface surface = surface_of(scattered());
  EXPECT_LT(mean_span(surface), 400);
}

TEST(OrderForCache, KeepsTheWayBackToTheFile) {
  const Shape shape = scattered();
  const Surface surface = surface_of(shape);
  std::set<Index> seen;
  for (std::size_t v = 0; v < shape.positions.size(); ++v) {
    const Index at = surface.weld[v];
    EXPECT_EQ(surface.mesh.positions[at], surface.mesh.frame.to_local(shape.positions[v]));
    seen.insert(at);
  }
  EXPECT_EQ(seen.size(), shape.positions.size());
  seen.clear();
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    const Triangle& from = shape.triangles[surface.source_triangle[t]];
    const Triangle expected{surface.weld[from[0]], surface.weld[from[1]], surface.weld[from[2]]};
    EXPECT_EQ(surface.mesh.triangles[t], expected);
    seen.insert(surface.source_triangle[t]);
  }
  EXPECT_EQ(seen.size(), shape.triangles.size());
}

TEST(OrderForCache, LeavesSmallAndTidyMeshesAlone) {
  const Shape small = with_vertex_order(sphere(4), shuffled(sphere(4).positions.size()));
  const Shape tidy = grid(120);
  for (const Shape& shape : {small, tidy}) {
    const Surface surface = surface_of(shape);
    for (std::size_t v = 0; v < shape.positions.size(); ++v) ASSERT_EQ(surface.weld[v], v);
    EXPECT_EQ(surface.mesh.triangles, shape.triangles);
  }
}

TEST(OrderForCache, NamesTheFirstOddTriangleOfTheFile) {
  Shape shape = scattered();
  for (const std::size_t t : {700U, 9000U, 15000U}) std::swap(shape.triangles[t][0], shape.triangles[t][1]);
  const Surface surface = surface_of(shape);
  Index first = 700;  // or a neighbour of an odd one that comes before it
  const auto shared = [&](const Triangle& a, const Triangle& b) {
    int count = 0;
    for (const Index v : a) count += v == b[0] || v == b[1] || v == b[2];
    return count;
  };
  for (Index t = 0; t < 700; ++t) {
    for (const std::size_t odd : {700U, 9000U, 15000U}) {
      if (shared(shape.triangles[t], shape.triangles[odd]) == 2) first = std::min(first, t);
    }
  }
  const auto number = [](Index t) { return "triangle " + std::to_string(t); };
  const auto warnings = surface_warnings(surface, number, number);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(warnings.front().message.ends_with(" first: " + number(first))) << warnings.front().message;
}

TEST(OrderForCache, DoesNotChangeTheNoiseOfASeed) {
  const Shape shape = scattered();
  Surface sorted = surface_of(shape);
  Surface unsorted = sorted;  // the same mesh as the file has it
  unsorted.mesh.positions.clear();
  for (const Vec3d& p : shape.positions) unsorted.mesh.positions.push_back(sorted.mesh.frame.to_local(p));
  unsorted.mesh.triangles = shape.triangles;
  std::iota(unsorted.weld.begin(), unsorted.weld.end(), Index{0});
  ASSERT_TRUE(add_noise(sorted, {.seed = 3}));
  ASSERT_TRUE(add_noise(unsorted, {.seed = 3}));
  for (std::size_t v = 0; v < shape.positions.size(); ++v) {
    const Vec3f gap = sorted.mesh.positions[sorted.weld[v]] - unsorted.mesh.positions[v];
    EXPECT_LT(length(gap), 1e-6F);
  }
}

TEST(ValenceOrder, VisitsEveryMovableVertexOnceUnderItsValence) {
  const Surface surface = surface_of(with_noise(grid(60), 0.1));
  std::vector<std::uint8_t> movable(surface.mesh.positions.size());
  for (std::size_t v = 0; v < movable.size(); ++v) movable[v] = v % 7 != 0;
  const ValenceOrder order(surface.topology, movable);
  std::vector<int> visits(movable.size());
  for (std::size_t begin = 0; begin < movable.size(); begin += block_size(movable.size())) {
    order.for_each_group(begin, [&](const ValenceOrder::Group& group) {
      for (const Index& v : group.vertices) {
        EXPECT_EQ(v / block_size(movable.size()), begin / block_size(movable.size()));
        ++visits[v];
        if (group.valence == ValenceOrder::kOther) {
          EXPECT_TRUE(surface.topology.has(v, kBoundaryVertex));
        } else {
          EXPECT_EQ(surface.topology.vertex_neighbours[v].size(), group.valence);
          EXPECT_EQ(surface.topology.vertex_faces[v].size(), group.valence);
          const std::size_t row = static_cast<std::size_t>(&v - group.vertices.data()) * group.valence;
          for (std::size_t k = 0; k < group.valence; ++k) {
            EXPECT_EQ(group.neighbours[row + k], 2 * surface.topology.vertex_neighbours[v][k]);
          }
        }
      }
    });
  }
  for (std::size_t v = 0; v < movable.size(); ++v) EXPECT_EQ(visits[v], movable[v]);
}

TEST(ValenceOrder, RingsGoRoundAndKnowWhatLiesBeyond) {
  Shape shape = with_noise(grid(70), 0.1);  // three blocks
  for (std::size_t t = 0; t < shape.triangles.size(); t += 3)
    std::swap(shape.triangles[t][0], shape.triangles[t][1]);
  shape.triangles.erase(shape.triangles.begin() + 3000, shape.triangles.begin() + 3005);  // a hole
  const Surface surface = surface_of(shape);
  std::map<std::set<Index>, std::set<Index>> thirds;  // of the triangles at each edge
  std::set<std::set<Index>> triangles;
  for (const auto& [a, b, c] : surface.mesh.triangles) {
    triangles.insert({a, b, c});
    thirds[{a, b}].insert(c), thirds[{b, c}].insert(a), thirds[{c, a}].insert(b);
  }
  const std::vector<std::uint8_t> movable(surface.mesh.positions.size(), 1);
  std::size_t rows = 0, open = 0;
  for (const unsigned threads : {1U, 2U}) {
    const ValenceOrder order(surface.mesh.triangles, surface.topology, movable, {.threads = threads});
    for (std::size_t begin = 0; begin < movable.size(); begin += block_size(movable.size())) {
      order.for_each_group(begin, [&](const ValenceOrder::Group& group) {
        if (group.valence == ValenceOrder::kOther) return;
        ASSERT_EQ(group.neighbours.size(), group.vertices.size() * group.valence);
        ASSERT_EQ(group.beyond.size(), group.neighbours.size());
        for (std::size_t i = 0; i < group.vertices.size(); ++i, ++rows) {
          const Index v = group.vertices[i];
          const auto ring = group.neighbours.subspan(i * group.valence, group.valence);
          EXPECT_EQ(std::set<Index>(ring.begin(), ring.end()).size(),
                    surface.topology.vertex_faces[v].size());
          for (std::size_t k = 0; k < group.valence; ++k) {
            const Index a = ring[k] / 2, b = ring[(k + 1) % group.valence] / 2;
            EXPECT_TRUE(triangles.contains({v, a, b})) << v << ": " << a << ", " << b;
            std::set<Index> other = thirds[{a, b}];
            other.erase(v);
            EXPECT_EQ(group.beyond[i * group.valence + k], 2 * (other.empty() ? a : *other.begin()));
            open += other.empty();
          }
        }
      });
    }
  }
  EXPECT_GT(rows, 9000U);
  EXPECT_GT(open, 100U);
}

bool same_bits(const SimdVec3::Lanes& a, const SimdVec3::Lanes& b) {
  for (int k = 0; k < 4; ++k) {
    if (std::bit_cast<std::uint32_t>(a[k]) != std::bit_cast<std::uint32_t>(b[k])) return false;
  }
  return true;
}

TEST(AdaptiveKernels, GiveTheSameBitsWhateverTheWidthOfVectors) {
  const auto all = adaptive_kernels::kernels_here();
  const Surface surface = surface_of(with_noise(sphere(3), 0.03));
  std::vector<SimdVec3> from(surface.mesh.positions.begin(), surface.mesh.positions.end());
  for (Index v = 0; v < from.size(); v += 9)
    from[surface.topology.vertex_neighbours[v].front()] = from[v];  // some triangles have no area
  const Index flat = 400;                                           // nor has any at this one
  for (const Index w : surface.topology.vertex_neighbours[flat]) {
    for (const Index x : surface.topology.vertex_neighbours[w]) from[x] = from[flat];
  }
  const std::vector<std::uint8_t> movable(from.size(), 1);
  const ValenceOrder order(surface.mesh.triangles, surface.topology, movable);
  for (const std::size_t count :
       {std::size_t{1}, std::size_t{3}, std::size_t{4}, std::size_t{7}, from.size()}) {
    order.for_each_group(0, [&](const ValenceOrder::Group& group) {
      const bool only_offset = count == 7;
      ValenceOrder::Group part = group;
      part.vertices = group.vertices.first(std::min(count, group.vertices.size()));
      std::vector<SimdVec3> expected = from;
      all.front().move(part, only_offset, 900, from, expected);
      for (const Index v : part.vertices) EXPECT_TRUE(std::isfinite(length(expected[v]))) << v;
      for (const auto& wide : all) {
        std::vector<SimdVec3> to = from;
        wide.move(part, only_offset, 900, from, to);
        for (std::size_t v = 0; v < from.size(); ++v) {
          ASSERT_TRUE(same_bits(to[v].lanes(), expected[v].lanes())) << v << ", " << wide.bits << " bits";
        }
      }
    });
  }
}

TEST(AdaptiveKernels, CoefficientIsTheBoundedExponential) {
  for (int i = 0; i < 2900; ++i) {
    const float x = static_cast<float>(i) * 0.0007F;
    const double expected = std::min(1.5, std::exp(static_cast<double>(x)));
    EXPECT_NEAR(adaptive_kernels::exponential_coefficient(x), expected, 2e-7);
  }
  EXPECT_EQ(adaptive_kernels::exponential_coefficient(0), 1);
}

}  // namespace
}  // namespace burnish
