#include "core/smooth/conjugate_gradients.h"

#include <gtest/gtest.h>

namespace burnish {
namespace {

/// A chain: 2 + mass on the diagonal, -1 beside it. The last row is no unknown.
struct Chain {
  static constexpr std::size_t kRows = 3000;
  std::vector<float> inverse, inverse_mass;
  std::vector<SimdVec3> b, x;

  Chain() : inverse(kRows, 1 / 2.5F), inverse_mass(kRows, 1 / 0.5F), b(kRows), x(kRows) {
    inverse.back() = inverse_mass.back() = 0;
    for (std::size_t i = 0; i < kRows; ++i) b[i] = SimdVec3(1, static_cast<float>(i % 7), -2);
  }
  static void apply(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < std::min(end, kRows - 1); ++i) {
      q[i] = p[i] * 2.5F - p[i + 1] - (i > 0 ? p[i - 1] : SimdVec3{});
    }
  }
  /// Sum of |b - A x|^2 / mass.
  double residual() const {
    std::vector<SimdVec3> product(kRows);
    apply(x, product, 0, kRows);
    double sum = 0;
    for (std::size_t i = 0; i + 1 < kRows; ++i) {
      sum += 2 * static_cast<double>(dot(b[i] - product[i], b[i] - product[i]));
    }
    return sum;
  }
};

TEST(ConjugateGradients, ReachTheResidualThatTheyPromise) {
  for (const double enough : {1e2, 1.0, 1e-4, 1e-7}) {
    Chain chain;
    const auto report =
        ConjugateGradients(Chain::kRows)
            .solve(Chain::apply, {chain.inverse, chain.inverse_mass}, chain.b, chain.x, enough, 1000, {});
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->converged);
    EXPECT_LE(report->residual, enough);
    EXPECT_LE(chain.residual(), 1.01 * enough + 1e-8);
    EXPECT_EQ(chain.x.back().vec3(), Vec3f{});
  }
}

TEST(ConjugateGradients, SayWhenTheyDidNotGetThere) {
  Chain chain;
  const auto report =
      ConjugateGradients(Chain::kRows)
          .solve(Chain::apply, {chain.inverse, chain.inverse_mass}, chain.b, chain.x, 1e-4, 3, {});
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->converged);
  EXPECT_EQ(report->iterations, 3U);
}

TEST(ConjugateGradients, AnswerAStopWithinAnIteration) {
  Chain chain;
  std::stop_source source;
  int calls = 0;
  const auto apply = [&](auto p, auto q, std::size_t begin, std::size_t end) {
    if (++calls == 5) source.request_stop();
    Chain::apply(p, q, begin, end);
  };
  EXPECT_FALSE(ConjugateGradients(Chain::kRows)
                   .solve(apply, {chain.inverse, chain.inverse_mass}, chain.b, chain.x, 1e-7, 1000,
                          {.stop = source.get_token()}));
  EXPECT_EQ(calls, 5);
}

}  // namespace
}  // namespace burnish
