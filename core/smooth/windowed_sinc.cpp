#include "core/smooth/windowed_sinc.h"

#include <algorithm>
#include <cmath>

#include "core/run/math.h"
#include "core/run/parallel.h"
#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"

namespace burnish {
namespace {

double window_weight(WindowedSincParams::Window window, std::size_t n, std::size_t degree) {
  const double a = static_cast<double>(n) * kPi / static_cast<double>(degree + 1);
  switch (window) {
    case WindowedSincParams::Window::Hamming:
      return 0.54 + 0.46 * portable_cos(a);
    case WindowedSincParams::Window::Blackman:
      return 0.42 + 0.5 * portable_cos(a) + 0.08 * portable_cos(2 * a);
    case WindowedSincParams::Window::Hanning:
      return 0.5 + 0.5 * portable_cos(a);
    case WindowedSincParams::Window::Rectangle:
      break;
  }
  return 1;
}

double portable_sin(double x) { return portable_cos(x - kPi / 2); }

/// c_0 to c_N.
std::vector<double> coefficients(const WindowedSincParams& params, std::size_t degree) {
  const double x = 1 - params.pass_band / 2;
  const double band = portable_angle(std::sqrt(1 - x * x), x);
  std::vector<double> weights(degree + 1), at_band(degree + 1);
  for (std::size_t n = 0; n <= degree; ++n) {
    weights[n] = window_weight(params.window, n, degree) / kPi * (n == 0 ? 1 : 2 / static_cast<double>(n));
    at_band[n] = portable_cos(static_cast<double>(n) * band);  // T_n(cos band)
  }
  const auto coefficient = [&](std::size_t n, double phi) {
    return weights[n] * (n == 0 ? phi : portable_sin(static_cast<double>(n) * phi));
  };
  const auto passes = [&](double phi) {
    double sum = 0;
    for (std::size_t n = 0; n <= degree; ++n) sum += coefficient(n, phi) * at_band[n];
    return sum >= 1;
  };

  // An eighth of a ripple at a time, then halved: no ripple is missed.
  const double step = kPi / static_cast<double>(8 * (degree + 1));
  double phi = band;
  while (phi < kPi && !passes(phi)) phi += step;
  double low = std::max(band, phi - step);
  for (int i = 0; i < 50 && phi < kPi; ++i) {
    const double middle = (low + phi) / 2;
    (passes(middle) ? phi : low) = middle;
  }
  phi = std::min(phi, kPi);

  std::vector<double> result(degree + 1);
  double sum = 0;
  for (std::size_t n = 0; n <= degree; ++n) sum += result[n] = coefficient(n, phi);
  for (double& c : result) c /= sum;
  return result;
}

/// The polynomial, a degree per iteration. Works on D_n = T_n(1 + U/2) v - v, which is small, so little is
/// lost to rounding: D_0 = 0, D_1 = U(v)/2, D_(n+1) = 2 D_n + U(D_n) - D_(n-1) + U(v).
class Polynomial {
 public:
  Polynomial(const Surface& surface, std::span<const std::uint8_t> movable,
             std::span<const double> coefficients)
      : step_(surface, movable),
        coefficients_(coefficients),
        home_(surface.mesh.positions),
        slope_(home_.begin(), home_.end()),
        last_(home_.size()),
        now_(home_.size()),
        next_(home_.size()),
        sum_(home_.size()) {}

  bool prepare(std::span<const SimdVec3> from, const RunControl& run) {
    ++degree_;
    if (degree_ > 1) {
      last_.swap(now_);
      now_.swap(next_);
      return true;
    }
    return parallel_for(from.size(), run, [&](std::size_t begin, std::size_t end) {
      step_(1.0F, from, slope_, begin);
      for (std::size_t v = begin; v < end; ++v) {
        slope_[v] -= from[v];
        last_[v] = slope_[v] * 0.5F;  // D_(-1) = D_1
      }
    });
  }

  void move(std::span<SimdVec3> to, std::size_t begin, std::size_t end) {
    step_(0.5F, now_, next_, begin);
    const float c = static_cast<float>(coefficients_[degree_]);
    for (std::size_t v = begin; v < end; ++v) {
      next_[v] = next_[v] * 2.0F - last_[v] + slope_[v];
      sum_[v] += next_[v] * c;
    }
    if (degree_ + 1 < coefficients_.size()) return;  // only the whole sum is a surface
    for (std::size_t v = begin; v < end; ++v) to[v] = SimdVec3(home_[v]) + sum_[v];
  }

 private:
  UmbrellaStep step_;
  std::span<const double> coefficients_;
  std::span<const Vec3f> home_;
  std::vector<SimdVec3> slope_;              // U(v)
  std::vector<SimdVec3> last_, now_, next_;  // D_(n-1), D_n, D_(n+1); 0 where a vertex stays
  std::vector<SimdVec3> sum_;                // of c_n D_n
  std::size_t degree_ = 0;                   // n + 1
};

}  // namespace

Result<SmoothOutcome> smooth_windowed_sinc(Surface& surface, const WindowedSincParams& params,
                                           const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const std::vector<double> c = coefficients(params, options.iterations);
  Polynomial polynomial(surface, constraints.movable(), c);
  return iterate(
      surface, constraints, options, run,
      {.prepare = [&](auto from) { return polynomial.prepare(from, run); },
       .move = [&](auto, auto to, std::size_t begin, std::size_t end) { polynomial.move(to, begin, end); }});
}

Method windowed_sinc_method() {
  using P = WindowedSincParams;
  constexpr P kDefaults;
  Method method{
      .name = "windowed_sinc",
      .summary =
          "A low-pass filter of the umbrella operator, designed as a windowed sinc: keeps what is below "
          "the pass band, removes the rest.",
      .reference =
          "G. Taubin, T. Zhang, G. Golub, Optimal surface smoothing as filter design, ECCV 1996, "
          "283-292",
      .formula =
          "v' = sum over n to N of c_n T_n(1 + U/2) v,  c_n = w_n 2 sin(n phi)/(n pi),  N = iterations, "
          " sum c_n = 1,  phi from the pass band",
      .parameters = with_iteration_parameters(
          {number_parameter("pass_band", kDefaults.pass_band, 0, 2, "1",
                            "Frequencies of the umbrella operator, 0 to 2, up to this stay."),
           choice_parameter("window", {"hamming", "blackman", "hanning", "rectangle"},
                            "Weights w_n; they trade the width of the transition for ripples.")}),
      .work_memory = {.per_vertex = 210, .per_triangle = 15},
      .nanoseconds = 4,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        P params{.pass_band = values.number("pass_band")};
        if (values.choice("window") == "blackman") params.window = P::Window::Blackman;
        if (values.choice("window") == "hanning") params.window = P::Window::Hanning;
        if (values.choice("window") == "rectangle") params.window = P::Window::Rectangle;
        return smooth_windowed_sinc(surface, params, iteration_options(values, surface), run);
      }};
  for (ParameterSpec& spec : method.parameters) {
    if (spec.name != "iterations") continue;
    spec.maximum = kMostSincDegree;
    spec.text = "Degree N of the polynomial; one step each.";
  }
  return method;
}

}  // namespace burnish
