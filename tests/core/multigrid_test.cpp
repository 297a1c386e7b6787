#include "core/smooth/multigrid.h"

#include <gtest/gtest.h>

#include <random>

#include "core/smooth/conjugate_gradients.h"
#include "tests/support/shapes.h"

namespace burnish::testing {
namespace {

/// A grid's vertices, drawn together by weights of 100 to 3000 and held by masses of 1. Those on the boundary
/// are no unknowns.
struct Drawn {
  Surface surface;
  const IndexRows& neighbours = surface.topology.vertex_neighbours;
  std::size_t rows = surface.mesh.positions.size();
  std::vector<float> weights, diagonal, inverse, inverse_mass;

  explicit Drawn(int side)
      : surface(surface_of(with_noise(grid(side), 0.1))),
        weights(neighbours.items.size()),
        diagonal(rows),
        inverse(rows),
        inverse_mass(rows) {
    for (Index v = 0; v < rows; ++v) {
      float sum = 1;
      for (Index k = neighbours.offsets[v]; k < neighbours.offsets[v + 1]; ++k) {
        const Index w = neighbours.items[k];
        weights[k] = (v + w) % 5 == 0 ? 3000.0F : 100.0F;
        sum += weights[k];
      }
      if (surface.topology.has(v, kBoundaryVertex)) continue;
      diagonal[v] = sum, inverse[v] = 1 / sum, inverse_mass[v] = 1;
    }
  }
  void multiply(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin) const {
    for (std::size_t v = begin; v < std::min(begin + block_size(rows), rows); ++v) {
      if (diagonal[v] == 0) continue;
      SimdVec3 sum = p[v] * diagonal[v];
      for (Index k = neighbours.offsets[v]; k < neighbours.offsets[v + 1]; ++k)
        sum -= p[neighbours.items[k]] * weights[k];
      q[v] = sum;
    }
  }
  bool build(Multigrid& multigrid, const RunControl& run = {}) const {
    return multigrid.build(
        neighbours, weights, diagonal,
        [this](std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin) {
          multiply(p, q, begin);
        },
        run);
  }
  std::vector<SimdVec3> random_right(unsigned seed) const {
    std::mt19937 random(seed);
    const auto any = [&] { return static_cast<float>(random() % 2001) / 1000 - 1; };
    std::vector<SimdVec3> b(rows);
    for (std::size_t v = 0; v < rows; ++v) {
      if (diagonal[v] > 0) b[v] = SimdVec3(any(), any(), any());
    }
    return b;
  }
};

double product(const std::vector<SimdVec3>& a, const std::vector<SimdVec3>& b) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) sum += static_cast<double>(dot(a[v], b[v]));
  return sum;
}

TEST(Multigrid, IsSymmetricAndPositiveDefinite) {
  const Drawn drawn(40);
  Multigrid multigrid;
  ASSERT_TRUE(drawn.build(multigrid));
  for (unsigned seed = 1; seed < 5; ++seed) {
    const auto a = drawn.random_right(seed), b = drawn.random_right(seed + 100);
    std::vector<SimdVec3> za(drawn.rows), zb(drawn.rows);
    ASSERT_TRUE(multigrid.apply(a, za, {}) && multigrid.apply(b, zb, {}));
    EXPECT_GT(product(a, za), 0);
    EXPECT_NEAR(product(za, b), product(a, zb), 1e-5 * std::sqrt(product(a, za) * product(b, zb)));
    for (std::size_t v = 0; v < drawn.rows; ++v) {
      EXPECT_TRUE(drawn.diagonal[v] > 0 || za[v].vec3() == Vec3f{});
    }
  }
}

TEST(Multigrid, SpreadsAChangeOverTheMeshInAFewIterationsOfGradients) {
  struct Plain {
    const Drawn& drawn;
    void operator()(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin,
                    std::size_t) const {
      drawn.multiply(p, q, begin);
    }
  };
  struct Preconditioned : Plain {
    Multigrid& multigrid;
    bool precondition(std::span<const SimdVec3> r, std::span<SimdVec3> z) const {
      return multigrid.apply(r, z, {});
    }
  };
  for (const int side : {60, 200}) {
    const Drawn drawn(side);
    Multigrid multigrid;
    ASSERT_TRUE(drawn.build(multigrid));
    const auto b = drawn.random_right(7);
    std::vector<SimdVec3> plain(drawn.rows), quick(drawn.rows);
    const SystemDiagonals diagonals{drawn.inverse, drawn.inverse_mass};
    const double enough = 1e-8 * product(b, b);
    ConjugateGradients gradients(drawn.rows);
    const auto slow = gradients.solve(Plain{drawn}, diagonals, b, plain, enough, 5000, {});
    const auto fast =
        gradients.solve(Preconditioned{{drawn}, multigrid}, diagonals, b, quick, enough, 60, {});
    ASSERT_TRUE(slow && fast && slow->converged && fast->converged);
    EXPECT_LT(fast->iterations, 40U) << side;
    EXPECT_GT(slow->iterations, 3 * fast->iterations) << side;
    for (std::size_t v = 0; v < drawn.rows; ++v) {  // both are within the root of `enough` of the solution
      EXPECT_LT(length(plain[v] - quick[v]), 2 * std::sqrt(enough));
    }
  }
}

TEST(Multigrid, GivesTheSameBitsForAnyNumberOfThreads) {
  const Drawn drawn(120);
  const auto b = drawn.random_right(3);
  std::vector<std::vector<SimdVec3>> results;
  for (const unsigned threads : {1U, 2U}) {
    Multigrid multigrid;
    ASSERT_TRUE(drawn.build(multigrid, {.threads = threads}));
    results.emplace_back(drawn.rows);
    ASSERT_TRUE(multigrid.apply(b, results.back(), {.threads = threads}));
  }
  for (std::size_t v = 0; v < drawn.rows; ++v) EXPECT_EQ(results[0][v].vec3(), results[1][v].vec3());
}

TEST(Multigrid, SolvesRowsThatNothingDrawsByTheirMass) {
  Drawn drawn(12);
  std::ranges::fill(drawn.weights, 0.0F);
  for (float& d : drawn.diagonal) d = d > 0 ? 4.0F : 0.0F;
  Multigrid multigrid;
  ASSERT_TRUE(drawn.build(multigrid));
  const auto b = drawn.random_right(1);
  std::vector<SimdVec3> z(drawn.rows);
  ASSERT_TRUE(multigrid.apply(b, z, {}));
  for (std::size_t v = 0; v < drawn.rows; ++v) EXPECT_LT(length(z[v] * 4 - b[v]), 1e-3F);
}

TEST(Multigrid, AnswersAStop) {
  const Drawn drawn(60);
  Multigrid multigrid;
  std::stop_source source;
  source.request_stop();
  EXPECT_FALSE(drawn.build(multigrid, {.stop = source.get_token()}));
  ASSERT_TRUE(drawn.build(multigrid));
  std::vector<SimdVec3> z(drawn.rows);
  EXPECT_FALSE(multigrid.apply(drawn.random_right(1), z, {.stop = source.get_token()}));
}

}  // namespace
}  // namespace burnish::testing
