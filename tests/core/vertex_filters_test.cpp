// The filters of vertices against their slow twins, and the linear ones against their transfer functions.
#include <gtest/gtest.h>

#include <cmath>

#include "core/run/math.h"
#include "core/smooth/bilaplacian.h"
#include "core/smooth/bilateral.h"
#include "core/smooth/hc_laplacian.h"
#include "core/smooth/laplacian.h"
#include "core/smooth/taubin.h"
#include "core/smooth/windowed_sinc.h"
#include "tests/support/compared.h"
#include "tests/support/oracle_vertex.h"

namespace burnish {
namespace {

using namespace burnish::testing;

Smooth laplacian(const LaplacianParams& params) {
  return
      [=](Surface& s, const IterationOptions& options) { return smooth_laplacian(s, params, options, {}); };
}
Smooth taubin(const TaubinParams& params) {
  return [=](Surface& s, const IterationOptions& options) { return smooth_taubin(s, params, options, {}); };
}
Smooth bilaplacian(const BilaplacianParams& params) {
  return
      [=](Surface& s, const IterationOptions& options) { return smooth_bilaplacian(s, params, options, {}); };
}
Smooth hc_laplacian(const HcLaplacianParams& params) {
  return [=](Surface& s, const IterationOptions& options) {
    return smooth_hc_laplacian(s, params, options, {});
  };
}
Smooth windowed_sinc(const WindowedSincParams& params) {
  return [=](Surface& s, const IterationOptions& options) {
    return smooth_windowed_sinc(s, params, options, {});
  };
}
Smooth bilateral(const BilateralParams& params) {
  return
      [=](Surface& s, const IterationOptions& options) { return smooth_bilateral(s, params, options, {}); };
}

// ---- against the oracles

class VertexOracle : public ::testing::TestWithParam<int> {
 protected:
  /// On closed and open, rough and sharp shapes; `loss` is what rounding costs an iteration, beside
  /// laplacian's.
  void expect_agreement(int iterations, const Smooth& smooth,
                        const std::function<Shape(const Shape&)>& oracle, double loss = 1) {
    for (const Shape& shape : various_shapes()) {
      const double h = mean_edge_of(shape);
      const Shape result = smoothed(shape, smooth, {.iterations = static_cast<std::uint32_t>(iterations)});
      EXPECT_GT(largest_distance(result, shape), 1e-3 * h);
      EXPECT_LT(largest_distance(result, oracle(shape)), loss * 2e-6 * (1 + iterations) * h);
    }
  }
};

TEST_P(VertexOracle, AgreesWithBilaplacian) {
  for (const double lambda : {0.25, 0.5}) {
    expect_agreement(GetParam(), bilaplacian({.lambda = lambda}),
                     [=](const Shape& shape) { return oracle_bilaplacian(shape, lambda, GetParam()); });
  }
}

TEST_P(VertexOracle, AgreesWithHcLaplacian) {
  for (const HcLaplacianParams& params :
       {HcLaplacianParams{}, HcLaplacianParams{.alpha = 0.3, .beta = 0.7}, HcLaplacianParams{.alpha = 1}}) {
    expect_agreement(GetParam(), hc_laplacian(params),
                     [=](const Shape& shape) { return oracle_hc_laplacian(shape, params, GetParam()); });
  }
}

TEST_P(VertexOracle, AgreesWithWindowedSincInEveryWindow) {
  using P = WindowedSincParams;
  for (const P& params : {P{}, P{.pass_band = 0}, P{.window = P::Window::Rectangle}}) {
    expect_agreement(GetParam(), windowed_sinc(params),
                     [=](const Shape& shape) { return oracle_windowed_sinc(shape, params, GetParam()); });
  }
  if (GetParam() == 1) return;  // the others let all pass in the first degree
  for (const P& params :
       {P{.pass_band = 0.6}, P{.window = P::Window::Blackman}, P{.window = P::Window::Hanning}}) {
    expect_agreement(GetParam(), windowed_sinc(params),
                     [=](const Shape& shape) { return oracle_windowed_sinc(shape, params, GetParam()); });
  }
}

TEST_P(VertexOracle, AgreesWithBilateral) {
  using P = BilateralParams;
  for (const P& params : {P{}, P{.sigma_s = 0.2}, P{.sigma_c = 0.4, .sigma_s = 2}}) {
    expect_agreement(
        GetParam(), bilateral(params),
        [=](const Shape& shape) { return oracle_bilateral(shape, params, GetParam()); }, 10);
  }
}

TEST_P(VertexOracle, AgreesWithBilateralInABall) {
  // More iterations shrink shapes this small until the ball holds more than kMostInBall.
  const int iterations = std::min(GetParam(), static_cast<int>(kBilateralIterations));
  using P = BilateralParams;
  for (const P& params : {P{.neighbourhood = P::Neighbourhood::Ball},
                          P{.sigma_c = 1.3, .sigma_s = 0.5, .neighbourhood = P::Neighbourhood::Ball}}) {
    expect_agreement(
        iterations, bilateral(params),
        [=](const Shape& shape) { return oracle_bilateral(shape, params, iterations); }, 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Iterations, VertexOracle, ::testing::Values(1, 20));

// ---- against the transfer functions

/// A ring on which every vertex has six neighbours and the umbrella operator is a convolution: its
/// eigenvectors are waves, with eigenvalues -k in closed form.
constexpr int kAround = 40, kAlong = 30;

struct Wave {
  int around, along;
  double k() const {
    const double a = 2 * kPi * around / kAround, b = 2 * kPi * along / kAlong;
    return 1 - (std::cos(a) + std::cos(b) + std::cos(a + b)) / 3;
  }
  double at(int i, int j, double phase) const {
    return std::cos(
        2 * kPi * (static_cast<double>(around * i) / kAround + static_cast<double>(along * j) / kAlong) +
        phase);
  }
};

/// A constant offset, slow waves that hold the vertices apart, and `wave`; each times its factor.
Shape ring(const Wave& wave, const std::function<double(double)>& factor) {
  const Wave turn{1, 0}, tube{0, 1};
  const Vec3d offset = Vec3d{5, -3, 2} * factor(0);
  const double wide = 4 * factor(turn.k()), thick = factor(tube.k()), high = 0.3 * factor(wave.k());
  Shape shape;
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAlong; ++j) {
      const double w = high * wave.at(i, j, 0.4);
      shape.positions.push_back(offset + Vec3d{wide * turn.at(i, j, 0), wide * turn.at(i, j, -kPi / 2), 0} +
                                Vec3d{thick * tube.at(i, j, 0), 0, thick * tube.at(i, j, -kPi / 2)} +
                                Vec3d{0, w, w});
    }
  }
  const auto at = [](int i, int j) { return static_cast<Index>((i % kAround) * kAlong + j % kAlong); };
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAlong; ++j) {
      shape.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      shape.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return shape;
}

struct Filter {
  const char* name;
  Smooth smooth;
  std::function<double(double k, int iterations)> transfer;
};

double hc_transfer(const HcLaplacianParams& params, double k, int iterations) {
  double p = 1;
  for (int i = 0; i < iterations; ++i) {
    const double q = (1 - k) * p, b = q - (params.alpha + (1 - params.alpha) * p);
    p = q - (params.beta * b + (1 - params.beta) * (1 - k) * b);
  }
  return p;
}

std::vector<Filter> filters() {
  using P = WindowedSincParams;
  const HcLaplacianParams pulled{.alpha = 0.2, .beta = 0.6};
  return {
      {"laplacian", laplacian({}), [](double k, int n) { return std::pow(1 - 0.5 * k, n); }},
      {"taubin", taubin({}), [](double k, int n) { return std::pow((1 - 0.5 * k) * (1 + 0.53 * k), n); }},
      {"bilaplacian", bilaplacian({}), [](double k, int n) { return std::pow(1 - 0.25 * k * k, n); }},
      {"hc_laplacian", hc_laplacian({}), [](double k, int n) { return std::pow(1 - 0.5 * k * k, n); }},
      {"hc_laplacian, pulled", hc_laplacian(pulled),
       [=](double k, int n) { return hc_transfer(pulled, k, n); }},
      {"windowed_sinc", windowed_sinc({}), [](double k, int n) { return oracle_sinc_transfer({}, n, k); }},
      {"windowed_sinc, wide", windowed_sinc({.pass_band = 0.5, .window = P::Window::Hanning}),
       [](double k, int n) {
         return oracle_sinc_transfer({.pass_band = 0.5, .window = P::Window::Hanning}, n, k);
       }},
  };
}

TEST(LinearFilters, TakeEveryFrequencyByTheirTransferFunction) {
  for (const Wave& wave : {Wave{0, 0}, Wave{2, 1}, Wave{5, 3}, Wave{12, 0}, Wave{13, 10}, Wave{20, 15}}) {
    const Shape start = ring(wave, [](double) { return 1.0; });
    ASSERT_EQ(surface_of(start).mesh.positions.size(), std::size_t{kAround * kAlong});
    for (const Filter& filter : filters()) {
      for (const int iterations : {1, 7, 20}) {
        const Shape expected = ring(wave, [&](double k) { return filter.transfer(k, iterations); });
        const Shape result =
            smoothed(start, filter.smooth, {.iterations = static_cast<std::uint32_t>(iterations)});
        EXPECT_LT(largest_distance(result, expected), 2e-6 * (3 + iterations))
            << filter.name << ", k " << wave.k() << ", iterations " << iterations;
      }
    }
  }
}

TEST(LinearFilters, KeepTheCentre) {
  for (const Filter& filter : filters()) {
    EXPECT_NEAR(filter.transfer(0, 20), 1, 1e-12) << filter.name;
    const Shape start = with_noise(ring({13, 10}, [](double) { return 1.0; }), 0.1);
    const Shape result = smoothed(start, filter.smooth, {.iterations = 20});
    Vec3d drift;
    for (std::size_t v = 0; v < start.positions.size(); ++v)
      drift += result.positions[v] - start.positions[v];
    EXPECT_LT(length(drift) / static_cast<double>(start.positions.size()), 1e-6) << filter.name;
  }
}

TEST(WindowedSinc, PassesItsBandAndStopsWhatIsHigh) {
  using P = WindowedSincParams;
  struct Row {
    P params;
    double stop;  // the transition is as wide as the window makes it
  };
  for (const auto& [params, stop] :
       {Row{{}, 0.9}, Row{{.window = P::Window::Hanning}, 0.9}, Row{{.window = P::Window::Blackman}, 1.6}}) {
    for (const double k : {0.0, 0.03, 0.07, 0.1})
      EXPECT_NEAR(oracle_sinc_transfer(params, 20, k), 1, 0.012) << k;
    for (double k = stop; k <= 2; k += 0.1) EXPECT_NEAR(oracle_sinc_transfer(params, 20, k), 0, 0.012) << k;
  }
  // What those numbers are, the filter does: the wave of k = 1.5 is all that separates these two rings.
  const auto plain = [](double) { return 1.0; };
  const Wave rough{13, 10};
  ASSERT_GT(rough.k(), 1.49);
  const Shape low = ring({1, 1}, plain);
  EXPECT_LT(largest_distance(smoothed(low, windowed_sinc({}), {.iterations = 20}), low), 0.05);
  const Shape result = smoothed(ring(rough, plain), windowed_sinc({}), {.iterations = 20});
  const Shape without = ring(rough, [&](double k) { return k == rough.k() ? 0.0 : 1.0; });
  EXPECT_LT(largest_distance(result, without), 0.05);
  EXPECT_GT(largest_distance(ring(rough, plain), without), 0.4);
}

TEST(WindowedSinc, KeepsTheSizeOfASphere) {
  const Shape shape = sphere(3);
  for (const std::uint32_t degree : {10U, 20U, 100U, 1000U}) {
    double sum = 0;
    for (const Vec3d& p : smoothed(shape, windowed_sinc({}), {.iterations = degree}).positions)
      sum += length(p);
    EXPECT_NEAR(sum / static_cast<double>(shape.positions.size()), 1, 0.005) << degree;
  }
}

// ---- what is special to one

/// A flat grid, one inner vertex of which was lifted and is held there.
Surface tent() {
  Shape shape = grid(20);
  for (Vec3d& p : shape.positions) {
    if (length(p - Vec3d{10, 10, 0}) < 1e-9) p.z = 2;
  }
  Surface surface = surface_of(shape);
  surface.pinned.assign(surface.mesh.positions.size(), 0);
  for (std::size_t v = 0; v < surface.pinned.size(); ++v) {
    const Vec3d p = surface.mesh.frame.to_file(to_double(surface.mesh.positions[v]));
    surface.pinned[v] = p.z > 1;
  }
  return surface;
}

/// How much higher the held vertex is than the mean of its neighbours.
double peak(const Surface& surface) {
  for (Index v = 0; v < surface.pinned.size(); ++v) {
    if (surface.pinned[v] == 0) continue;
    double mean = 0;
    const auto around = surface.topology.vertex_neighbours[v];
    for (const Index w : around) mean += static_cast<double>(surface.mesh.positions[w].z);
    return static_cast<double>(surface.mesh.positions[v].z) - mean / static_cast<double>(around.size());
  }
  return 0;
}

TEST(Bilaplacian, BendsSmoothlyAroundAPinnedVertexWhereLaplacianMakesATent) {
  Surface bent = tent(), stretched = tent();
  ASSERT_TRUE(smooth_bilaplacian(bent, {}, {.iterations = 2000}, {}));
  ASSERT_TRUE(smooth_laplacian(stretched, {}, {.iterations = 2000}, {}));
  EXPECT_LT(peak(bent), 0.4 * peak(stretched));
  EXPECT_GT(peak(bent), 0);
}

TEST(HcLaplacian, IsTheBilaplacianStepWhereNothingPullsBackToTheInput) {
  const Shape shape = with_noise(sphere(2), 0.05);
  EXPECT_LT(largest_distance(smoothed(shape, hc_laplacian({.beta = 0.75}), {.iterations = 5}),
                             smoothed(shape, bilaplacian({.lambda = 0.25}), {.iterations = 5})),
            2e-6);
}

TEST(Bilateral, KeepsTheEdgesOfACubeThatLaplacianRounds) {
  const Shape clean = cube(12);
  const Shape noisy = with_noise(clean, 0.02);
  const auto off_the_edges = [&](const Smooth& smooth) {
    const Shape result = smoothed(noisy, smooth, {.iterations = kBilateralIterations});
    double sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < clean.positions.size(); ++v) {
      int sides = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) sides += std::abs(clean.positions[v][axis]) > 1 - 1e-9;
      if (sides != 2) continue;
      sum += length(result.positions[v] - clean.positions[v]);
      ++count;
    }
    return sum / count;
  };
  EXPECT_LT(off_the_edges(bilateral({.sigma_s = 0.1})), 0.5 * off_the_edges(laplacian({})));
}

TEST(Bilateral, SmoothsAcrossTrianglesThatWindTheOtherWay) {
  const Shape shape = with_noise(sphere(3), 0.01);
  Shape mixed = shape;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  EXPECT_LT(largest_distance(smoothed(shape, bilateral({}), {.iterations = kBilateralIterations}),
                             smoothed(mixed, bilateral({}), {.iterations = kBilateralIterations})),
            1e-4);
}

}  // namespace
}  // namespace burnish
