#include "core/smooth/bilateral.h"

#include <algorithm>
#include <array>

#include "core/run/math.h"
#include "core/smooth/parameters.h"

namespace burnish {
namespace {

/// Where all heights are nearly the same, as around a spike, their standard deviation is next to nothing, and
/// rounding would choose the one vertex that counts: it is taken as at least this share of their root mean
/// square.
constexpr double kLeastShare = 0.3;

class Bilateral {
 public:
  Bilateral(const Surface& surface, const BilateralParams& params, std::span<const std::uint8_t> movable)
      : surface_(surface),
        topology_(surface.topology),
        movable_(movable),
        ball_(params.neighbourhood == BilateralParams::Neighbourhood::Ball),
        own_similarity_(params.sigma_s == 0) {
    const double h = surface.mean_edge, closeness = params.sigma_c * h, similarity = params.sigma_s * h;
    squared_radius_ = static_cast<float>(4 * closeness * closeness);
    per_closeness_ = 1 / (2 * closeness * closeness);
    per_similarity_ = own_similarity_ ? 0 : 1 / (2 * similarity * similarity);
  }

  void move(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
            std::size_t end) const {
    std::array<Index, kMostInBall> in_ball;
    for (std::size_t v = begin; v < end; ++v) {
      if (movable_[v] == 0) continue;
      const auto around = ball_ ? ball(from, static_cast<Index>(v), in_ball) : topology_.vertex_neighbours[v];
      const SimdVec3 n = normal(from, v);
      to[v] = from[v] + n * static_cast<float>(height(from, v, n, around));
    }
  }

 private:
  /// Unit, or zero when the triangles cancel out.
  SimdVec3 normal(std::span<const SimdVec3> from, std::size_t v) const {
    SimdVec3 sum;
    for (const Index f : topology_.vertex_faces[v]) {
      const Triangle& t = surface_.mesh.triangles[f];
      const SimdVec3 twice_area = cross(from[t[1]] - from[t[0]], from[t[2]] - from[t[0]]);
      // Where triangles wind either way, those against the others count the other way round.
      const bool against = !topology_.opposed_neighbours.empty() && dot(sum, twice_area) < 0;
      sum += against ? twice_area * -1.0F : twice_area;
    }
    const float size = length(sum);
    return size > 0 ? sum * (1 / size) : SimdVec3{};
  }

  /// The vertices within 2 sigma_c of v that are reached through such vertices, nearest by edges first.
  std::span<const Index> ball(std::span<const SimdVec3> from, Index v,
                              std::array<Index, kMostInBall>& found) const {
    std::size_t count = 0;
    const auto add_around = [&](Index at) {
      for (const Index w : topology_.vertex_neighbours[at]) {
        const SimdVec3 way = from[w] - from[v];
        if (count == found.size() || w == v || !(dot(way, way) < squared_radius_)) continue;
        const auto end = found.begin() + static_cast<std::ptrdiff_t>(count);
        if (std::find(found.begin(), end, w) == end) found[count++] = w;
      }
    };
    add_around(v);
    for (std::size_t i = 0; i < count; ++i) add_around(found[i]);
    return {found.data(), count};
  }

  /// How far to go along the normal.
  double height(std::span<const SimdVec3> from, std::size_t v, SimdVec3 n,
                std::span<const Index> around) const {
    const double per_similarity = own_similarity_ ? per_variance(from, v, n, around) : per_similarity_;
    double sum = 0, weights = 0;
    for (const Index q : around) {
      const SimdVec3 way = from[q] - from[v];
      const double h = static_cast<double>(dot(n, way));
      const double weight =
          portable_exp(-static_cast<double>(dot(way, way)) * per_closeness_ - h * h * per_similarity);
      sum += weight * h;
      weights += weight;
    }
    return weights > 0 ? sum / weights : 0;
  }

  /// 1 / (2 sigma_s^2), sigma_s the standard deviation of the heights around v, bounded below.
  double per_variance(std::span<const SimdVec3> from, std::size_t v, SimdVec3 n,
                      std::span<const Index> around) const {
    double sum = 0, squares = 0;
    for (const Index q : around) {
      const double h = static_cast<double>(dot(n, from[q] - from[v]));
      sum += h;
      squares += h * h;
    }
    const double count = static_cast<double>(around.size());
    const double variance =
        std::max(squares - sum * sum / count, kLeastShare * kLeastShare * squares) / count;
    return variance > 0 ? 1 / (2 * variance) : 0;
  }

  const Surface& surface_;
  const Topology& topology_;
  std::span<const std::uint8_t> movable_;
  bool ball_, own_similarity_;
  float squared_radius_ = 0;
  double per_closeness_ = 0, per_similarity_ = 0;
};

}  // namespace

Result<SmoothOutcome> smooth_bilateral(Surface& surface, const BilateralParams& params,
                                       const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  const Bilateral bilateral(surface, params, constraints.movable());
  return iterate(surface, constraints, options, run,
                 {.move = [&](auto from, auto to, std::size_t begin, std::size_t end) {
                   bilateral.move(from, to, begin, end);
                 }});
}

Method bilateral_method() {
  using P = BilateralParams;
  constexpr P kDefaults;
  return {
      .name = "bilateral",
      .summary =
          "Moves every vertex along its normal by the mean height of the vertices around it, where "
          "those near and of like height count most.",
      .reference = "S. Fleishman, I. Drori, D. Cohen-Or, Bilateral mesh denoising, SIGGRAPH 2003, 950-953",
      .formula =
          "v' = v + n sum w h / sum w over the neighbours q,  h = n . (q - v),  w = exp(-|q - v|^2 / "
          "(2 sigma_c^2)) exp(-h^2 / (2 sigma_s^2))",
      .parameters = with_iteration_parameters(
          {number_parameter("sigma_c", kDefaults.sigma_c, 0.1, 5, "mean edge lengths",
                            "Closeness: how near a vertex must be to count."),
           number_parameter("sigma_s", kDefaults.sigma_s, 0, 100, "mean edge lengths",
                            "Similarity: how like in height a vertex must be to count; 0 means the standard "
                            "deviation of the heights around each vertex."),
           choice_parameter("neighbourhood", {"ring", "ball"},
                            "Vertices that share an edge, or all within 2 sigma_c.")},
          kBilateralIterations),
      .work_memory = {.per_vertex = 125, .per_triangle = 0},
      .nanoseconds = 60,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        P params{.sigma_c = values.number("sigma_c"), .sigma_s = values.number("sigma_s")};
        if (values.choice("neighbourhood") == "ball") params.neighbourhood = P::Neighbourhood::Ball;
        return smooth_bilateral(surface, params, iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
