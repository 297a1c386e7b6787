#include "core/smooth/robust_normals.h"

#include "core/smooth/parameters.h"

namespace burnish {
namespace {

/// The offsets of all vertices, less what they would add to the volume.
class VolumeAwareMove {
 public:
  VolumeAwareMove(const Faces& faces, std::span<const std::uint8_t> movable)
      : faces_(faces), movable_(movable), ways_(movable.size()), normals_(movable.size()) {}

  bool measure(std::span<const SimdVec3> positions) {
    const double gained = sum([&](std::size_t v) {
      ways_[v] = faces_.offset_by_area(positions[v], v);
      normals_[v] = volume_gradient(positions, v);
      return dot(ways_[v], normals_[v]);
    });
    const double area = sum([&](std::size_t v) {
      const float size = length(normals_[v]);
      if (size > 0) normals_[v] = normals_[v] * (1 / size);
      return size;
    });
    excess_ = area > 0 ? static_cast<float>(gained / area) : 0;
    return !faces_.run().stopped();
  }

  SimdVec3 operator()(std::size_t v) const { return ways_[v] - normals_[v] * excess_; }

 private:
  template <class Term>
  double sum(Term&& term) {
    return parallel_sum(movable_.size(), faces_.run(), [&](std::size_t begin, std::size_t end) {
      double part = 0;
      for (std::size_t v = begin; v < end; ++v) {
        if (movable_[v] != 0) part += static_cast<double>(term(v));
      }
      return part;
    });
  }

  SimdVec3 volume_gradient(std::span<const SimdVec3> positions, std::size_t v) const {
    SimdVec3 sum;
    for (const Index f : faces_.surface().topology.vertex_faces[v]) {
      const auto& [a, b, c] = faces_.surface().mesh.triangles[f];
      sum += cross(positions[b] - positions[a], positions[c] - positions[a]) * faces_.side(f);
    }
    return sum * (1.0F / 6);
  }

  const Faces& faces_;
  std::span<const std::uint8_t> movable_;
  Buffer<SimdVec3> ways_, normals_;
  float excess_ = 0;
};

}  // namespace

Result<SmoothOutcome> smooth_robust_normals(Surface& surface, const RobustNormalsParams& params,
                                            const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Faces faces(surface, FaceNeighbourhood::Vertices, run);
  RobustFilter robust(faces);
  const RobustWidths widths{.first_threshold = params.first_threshold,
                            .second_threshold = params.second_threshold,
                            .sigma_c = params.sigma_c};
  VolumeAwareMove moves(faces, constraints.movable());
  return iterate_normals(
      surface, faces, constraints, options,
      {.filter =
           [&](std::span<const SimdVec3> from) {
             return faces.measure(from) && robust.filter(faces, widths, params.normal_steps);
           },
       .move = move_by(constraints, [&](auto, std::size_t v) { return moves(v); }),
       .vertex_steps = params.vertex_steps,
       .before_move = [&](std::span<const SimdVec3> from) { return moves.measure(from); }});
}

Method robust_normals_method() {
  constexpr RobustNormalsParams kDefaults;
  return {
      .name = "robust_normals",
      .summary =
          "Averages face normals in two stages by weights that are zero for neighbours turned away, the "
          "second by what the first made of them, and moves the vertices to fit while the volume stays.",
      .reference =
          "After S. K. Yadav, U. Reitebuch, K. Polthier, Robust and high fidelity mesh denoising, IEEE "
          "Transactions on Visualization and Computer Graphics 25 (2019) 2304-2310; the formulas are ours",
      .formula =
          "m(i) = unit(sum over neighbours j of A(j) exp(-|c(i) - c(j)|^2 / (2 sigma_c^2)) rho(|n(i) - n(j)| "
          "/ first_threshold) n(j)),  n'(i) = the same sum with rho(|m(i) - m(j)| / second_threshold),  "
          "rho(x) = (1 - x^2)^2 for x < 1 else 0,  v' = v + 1/sum A(f) sum over triangles f at v of A(f) "
          "[(c(f) - v) . n'(f)] n'(f) - mu u(v),  u = unit volume gradient, mu so that the volume stays to "
          "first order",
      .parameters = with_iteration_parameters({
          number_parameter("first_threshold", kDefaults.first_threshold, 0.01, 10, "1",
                           "Difference of unit normals from which on a neighbour does not count, in the "
                           "first stage; more for more noise."),
          number_parameter("second_threshold", kDefaults.second_threshold, 0.01, 10, "1",
                           "The same in the second stage, of the normals that the first one made: less "
                           "keeps blunter edges."),
          centroid_distance_parameter("sigma_c", kDefaults.sigma_c),
          count_parameter("normal_steps", kDefaults.normal_steps, 1, 100,
                          "How often each stage filters the normals in a row."),
          vertex_steps_parameter(kDefaults.vertex_steps),
      }),
      .work_memory = {.per_vertex = 145, .per_triangle = 100},
      .nanoseconds = 550,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_robust_normals(
            surface,
            {.first_threshold = values.number("first_threshold"),
             .second_threshold = values.number("second_threshold"),
             .sigma_c = values.number("sigma_c"),
             .normal_steps = static_cast<std::uint32_t>(values.integer("normal_steps")),
             .vertex_steps = static_cast<std::uint32_t>(values.integer("vertex_steps"))},
            iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
