#include "core/smooth/hc_laplacian.h"

#include "core/run/parallel.h"
#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"

namespace burnish {
namespace {

class HcLaplacian {
 public:
  HcLaplacian(const Surface& surface, const HcLaplacianParams& params, std::span<const std::uint8_t> movable)
      : movable_(movable),
        step_(surface, movable),
        home_(surface.mesh.positions),
        back_(home_.size()),
        alpha_(static_cast<float>(params.alpha)),
        others_(static_cast<float>(1 - params.beta)) {}

  void prepare(std::span<const SimdVec3> from, std::size_t begin, std::size_t end) {
    step_(1.0F, from, back_, begin);  // q
    for (std::size_t v = begin; v < end; ++v) {
      if (movable_[v] != 0) back_[v] -= target(from, v);  // b
    }
  }

  /// q - (beta b + (1 - beta) mean of b) is target - (1 - beta) U(b), for q = target + b and mean = b + U(b).
  void move(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
            std::size_t end) const {
    step_(-others_, back_, to, begin);  // b - (1 - beta) U(b)
    for (std::size_t v = begin; v < end; ++v) {
      if (movable_[v] != 0) to[v] += target(from, v) - back_[v];
    }
  }

 private:
  /// alpha o + (1 - alpha) p
  SimdVec3 target(std::span<const SimdVec3> from, std::size_t v) const {
    return from[v] + (SimdVec3(home_[v]) - from[v]) * alpha_;
  }

  std::span<const std::uint8_t> movable_;
  UmbrellaStep step_;
  std::span<const Vec3f> home_;  // o
  std::vector<SimdVec3> back_;   // b; 0 where a vertex stays
  float alpha_, others_;
};

}  // namespace

Result<SmoothOutcome> smooth_hc_laplacian(Surface& surface, const HcLaplacianParams& params,
                                          const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  HcLaplacian hc(surface, params, constraints.movable());
  return iterate(surface, constraints, options, run,
                 {.prepare =
                      [&](auto from) {
                        return parallel_for(from.size(), run, [&](std::size_t begin, std::size_t end) {
                          hc.prepare(from, begin, end);
                        });
                      },
                  .move = [&](auto from, auto to, std::size_t begin,
                              std::size_t end) { hc.move(from, to, begin, end); }});
}

Method hc_laplacian_method() {
  constexpr HcLaplacianParams kDefaults;
  return {
      .name = "hc_laplacian",
      .summary =
          "Laplacian smoothing that pushes every vertex back by the mean of what it and its neighbours went, "
          "and so shrinks little.",
      .reference =
          "J. Vollmer, R. Mencl, H. Mueller, Improved Laplacian smoothing of noisy surface meshes, Computer "
          "Graphics Forum 18(3) (1999) 131-138",
      .formula =
          "q = p + U(p),  b = q - (alpha o + (1 - alpha) p),  p' = q - (beta b + (1 - beta) mean of the "
          "neighbours' b),  o the input",
      .parameters = with_iteration_parameters(
          {number_parameter("alpha", kDefaults.alpha, 0, 1, "1",
                            "Pulls back to the input (1) or to the last iteration (0)."),
           number_parameter("beta", kDefaults.beta, 0.5, 1, "1",
                            "Share of a vertex's own way in what it is pushed back by; below 0.5 the highest "
                            "frequencies would grow.")}),
      .work_memory = {.per_vertex = 140, .per_triangle = 15},
      .nanoseconds = 5,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_hc_laplacian(surface, {.alpha = values.number("alpha"), .beta = values.number("beta")},
                                   iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
