#include "core/smooth/weighted_least_squares.h"

#include <algorithm>

#include "core/run/math.h"
#include "core/run/parallel.h"
#include "core/smooth/normal_filter.h"
#include "core/smooth/parameters.h"

namespace burnish {
namespace {

class WeightedLeastSquares {
 public:
  WeightedLeastSquares(const Surface& surface, const WeightedLeastSquaresParams& params,
                       std::span<const std::uint8_t> movable, const RunControl& run)
      : surface_(surface),
        run_(run),
        lambda_(static_cast<float>(params.lambda)),
        per_squared_sigma_(static_cast<float>(1 / (params.sigma * params.sigma))),
        mass_of_twice_area_(static_cast<float>(1 / (6 * surface.mean_edge * surface.mean_edge))),
        faces_(surface, FaceNeighbourhood::Edges, run),
        vertices_(movable.size()),
        system_(surface, movable, params.solver, run) {}

  bool prepare(std::span<const SimdVec3> from) {
    const bool measured =
        faces_.measure(from) && parallel_for(vertices_.size(), run_, [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) vertices_[v] = measure(v);
        });
    return measured &&
           system_.solve(from, [&](std::size_t v, std::span<float> weights) { return fill_row(v, weights); });
  }

  const SparseSystem& system() const { return system_; }

 private:
  struct Vertex {
    SimdVec3 normal;
    float mass = 0;  // in squared mean edge lengths, as everything in the system
  };

  Vertex measure(std::size_t v) const {
    SimdVec3 sum;
    float twice_area = 0;
    for (const Index f : surface_.topology.vertex_faces[v]) {
      sum += faces_.normal(f) * faces_.twice_area(f);
      twice_area += faces_.twice_area(f);
    }
    const float size = length(sum);
    return {size > 0 ? sum * (1 / size) : SimdVec3{}, std::max(kLeastMass, twice_area * mass_of_twice_area_)};
  }

  /// lambda exp(-|n - n'|^2 / sigma^2) per neighbour; returns the mass.
  float fill_row(std::size_t v, std::span<float> weights) const {
    const std::span<const Index> neighbours = surface_.topology.vertex_neighbours[v];
    const Vertex& own = vertices_[v];
    for (std::size_t k = 0; k < weights.size(); k += 4) {
      const std::size_t count = std::min<std::size_t>(4, weights.size() - k);
      FourFloats exponents{};
      for (std::size_t i = 0; i < count; ++i) {
        const SimdVec3 difference = own.normal - vertices_[neighbours[k + i]].normal;
        exponents[i] = -dot(difference, difference) * per_squared_sigma_;
      }
      const FourFloats values = portable_exp(exponents) * lambda_;
      for (std::size_t i = 0; i < count; ++i) weights[k + i] = values[i];
    }
    return own.mass;
  }

  const Surface& surface_;
  const RunControl& run_;
  float lambda_, per_squared_sigma_, mass_of_twice_area_;
  Faces faces_;
  std::vector<Vertex> vertices_;
  SparseSystem system_;
};

}  // namespace

Result<SmoothOutcome> smooth_weighted_least_squares(Surface& surface,
                                                    const WeightedLeastSquaresParams& params,
                                                    const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  WeightedLeastSquares least_squares(surface, params, constraints.movable(), run);
  return iterate_system(surface, constraints, options, run, least_squares.system(),
                        [&](auto from) { return least_squares.prepare(from); });
}

Method weighted_least_squares_method() {
  constexpr WeightedLeastSquaresParams kDefaults;
  return {
      .name = "weighted_least_squares",
      .summary =
          "Finds the surface that is near the old one and smooth except across features, by one sparse "
          "solve per iteration.",
      .reference = "After the idea of Zhang 2010, weighted least squares; energy and weights are Burnish's",
      .formula =
          "min over x of sum M(v) |x_v - p_v|^2 + lambda sum over edges W(v, w) |x_v - x_w|^2,  W = "
          "exp(-|n(v) - n(w)|^2 / sigma^2),  M(v) = a third of the area at v",
      .parameters = with_solver_parameters(
          {number_parameter("lambda", kDefaults.lambda, 0, 1000, "squared mean edge lengths",
                            "Smoothness against nearness, per iteration."),
           number_parameter("sigma", kDefaults.sigma, 0.01, 100, "1",
                            "Difference of unit normals across which little is smoothed.")}),
      .work_memory = {.per_vertex = 400, .per_triangle = 65},
      .nanoseconds = 60,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_weighted_least_squares(surface,
                                             {.lambda = values.number("lambda"),
                                              .sigma = values.number("sigma"),
                                              .solver = solver_options(values)},
                                             iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
