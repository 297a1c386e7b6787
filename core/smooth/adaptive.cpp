#include "core/smooth/adaptive.h"

#include <algorithm>
#include <optional>

#include "core/mesh/faces_around.h"
#include "core/run/buffer.h"
#include "core/run/math.h"
#include "core/run/parallel.h"
#include "core/smooth/adaptive_kernels.h"
#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"
#include "core/smooth/valence_order.h"

namespace burnish {
namespace {

using adaptive_kernels::kTrianglesAtOnce;
using adaptive_kernels::kVanishing;
using adaptive_kernels::Row;

/// The paper's choices run in the kernels, all others here, one triangle or vertex at a time.
class Adaptive {
 public:
  Adaptive(const Surface& surface, const AdaptiveParams& params, std::span<const std::uint8_t> movable,
           const RunControl& run)
      : surface_(surface),
        topology_(surface.topology),
        params_(params),
        run_(run),
        order_(surface.topology, movable, ValenceOrder::With::NeighboursAndFaces, run),
        faces_((surface.mesh.triangles.size() + kTrianglesAtOnce - 1) / kTrianglesAtOnce * kTrianglesAtOnce),
        corners_(3 * faces_),
        area_normals_(surface.topology.opposed_neighbours.empty() ? faces_ + 1 : turned(faces_)),
        planes_(faces_) {
    const double scale = params.scale > 0 ? params.scale / surface.mesh.frame.scale() : surface.mean_edge;
    per_squared_scale_ = scale > 0 ? 1 / (scale * scale) : 0;
    if (as_printed_) across_.resize(corners_.size());
    for_each(faces_, run_, [&](std::size_t f) { fill(f); });
    area_normals_[faces_] = Row{};
    if (params.neighbourhood == AdaptiveParams::Neighbourhood::Vertices) around_.emplace(surface, run);
  }

  bool prepare(std::span<const SimdVec3> from) {
    const bool measured = parallel_for(faces_, run_, [&](std::size_t begin, std::size_t end) {
      kernels_.measure(corners_, from, begin, end, area_normals_, planes_);
      if (area_normals_.size() == faces_ + 1) return;
      for (std::size_t f = begin; f < end; ++f)
        area_normals_[turned(f)] = area_normals_[f] * Row{-1, -1, -1, 1};
    });
    if (!measured) return false;
    if (!as_printed_) {
      return for_each(surface_.mesh.triangles.size(), run_,
                      [&](std::size_t f) { planes_[f] = plane(from, f); });
    }
    return parallel_for(faces_, run_, [&](std::size_t begin, std::size_t end) {
      kernels_.expect(across_, area_normals_, begin, end, planes_);
    });
  }

  void move(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin) const {
    const bool plain = params_.offsets == AdaptiveParams::Offsets::Uniform &&
                       params_.umbrella == AdaptiveParams::Umbrella::Uniform &&
                       params_.coefficient == AdaptiveParams::Coefficient::Exponential;
    order_.for_each_group(begin, [&](const ValenceOrder::Group& group) {
      if (plain && group.valence != ValenceOrder::kOther) {
        kernels_.move(group, planes_, static_cast<float>(per_squared_scale_), from, to);
        return;
      }
      for (const Index v : group.vertices) {
        const float d = static_cast<float>(coefficient(from, v));
        to[v] = from[v] + offset(from[v], v) * d;  // Eq. 8
      }
    });
  }

 private:
  /// Where the area normal of triangle f stands once more, turned round, for a neighbour that winds the other
  /// way; after those of all triangles and a row of zeros, for sides without a neighbour.
  std::size_t turned(std::size_t f) const { return faces_ + 1 + f; }

  /// Corners and neighbours of triangle f; of none beyond the last.
  void fill(std::size_t f) {
    const bool none = f >= surface_.mesh.triangles.size();
    for (std::size_t side = 0; side < 3; ++side) {
      corners_[3 * f + side] = none ? 0 : doubled(surface_.mesh.triangles[f][side]);
      if (!as_printed_) continue;
      const Index neighbour = none ? kNone : topology_.face_neighbours[f][side];
      const std::size_t row = neighbour == kNone           ? faces_
                              : topology_.opposed(f, side) ? turned(neighbour)
                                                           : neighbour;
      across_[3 * f + side] = doubled(static_cast<Index>(row));
    }
  }

  /// m(R), Eq. 1: sum of A(S) n(S) over sum of A(S); n(R) where the neighbours cancel out or there are none.
  SimdVec3 expected_normal(std::size_t f) const {
    SimdVec3 sum;
    float areas = 0;
    const auto add = [&](Index neighbour, bool opposed) {
      const SimdVec3 area_normal = normal(neighbour);
      if (opposed) {
        sum -= area_normal;
      } else {
        sum += area_normal;
      }
      areas += twice_area(neighbour);
    };
    if (params_.neighbourhood == AdaptiveParams::Neighbourhood::Edges) {
      for (std::size_t side = 0; side < 3; ++side) {
        const Index neighbour = topology_.face_neighbours[f][side];
        if (neighbour != kNone) add(neighbour, topology_.opposed(f, side));
      }
    } else {
      around_->for_each(f, [&](Index neighbour) { add(neighbour, false); });
    }
    const float size = length(sum);
    if (size <= kVanishing * areas || areas == 0) {
      return twice_area(f) > 0 ? normal(f) * (1 / twice_area(f)) : SimdVec3{};
    }
    return sum * (1 / (params_.normals == AdaptiveParams::Normals::Unit ? size : areas));
  }

  SimdVec3 normal(std::size_t f) const {
    const Row& row = area_normals_[f];
    return {row[0], row[1], row[2]};
  }
  float twice_area(std::size_t f) const { return area_normals_[f][3]; }

  Row plane(std::span<const SimdVec3> from, std::size_t f) const {
    const Triangle& t = surface_.mesh.triangles[f];
    const SimdVec3 m = expected_normal(f);
    return Row{m.x(), m.y(), m.z(), dot(m, (from[t[0]] + from[t[1]] + from[t[2]]) * (1.0F / 3.0F))};
  }

  /// V, Eq. 2: the mean of [PC . m(R)] m(R) over the triangles R at P.
  SimdVec3 offset(SimdVec3 p, std::size_t v) const {
    SimdVec3 sum;
    float weights = 0;
    for (const Index f : topology_.vertex_faces[v]) {
      const float weight = params_.offsets == AdaptiveParams::Offsets::Area ? twice_area(f) : 1.0F;
      const Row& row = planes_[f];
      const SimdVec3 m(row[0], row[1], row[2]);
      sum += m * (weight * (row[3] - dot(p, m)));
      weights += weight;
    }
    return weights > 0 ? sum * (1 / weights) : SimdVec3{};
  }

  /// d = g(x), x = |U|^2 / scale^2, Eq. 3 to 7.
  double coefficient(std::span<const SimdVec3> from, std::size_t v) const {
    const SimdVec3 u = params_.umbrella == AdaptiveParams::Umbrella::Uniform
                           ? umbrella(from, topology_, v)
                           : inverse_length_umbrella(from, v);
    return offset_coefficient(params_, static_cast<double>(dot(u, u)) * per_squared_scale_);
  }

  SimdVec3 inverse_length_umbrella(std::span<const SimdVec3> from, std::size_t v) const {
    SimdVec3 sum;
    float weights = 0;
    for (const Index w : topology_.vertex_neighbours[v]) {
      const SimdVec3 way = from[w] - from[v];
      const float distance = length(way);
      if (distance == 0) continue;  // a neighbour in the same place pulls nowhere
      sum += way * (1 / distance);
      weights += 1 / distance;
    }
    return weights > 0 ? sum * (1 / weights) : SimdVec3{};
  }

  const Surface& surface_;
  const Topology& topology_;
  const AdaptiveParams& params_;
  const RunControl& run_;
  const adaptive_kernels::Kernels& kernels_ = adaptive_kernels::kernels();
  ValenceOrder order_;
  const bool as_printed_ = params_.normals == AdaptiveParams::Normals::Raw &&
                           params_.neighbourhood == AdaptiveParams::Neighbourhood::Edges;
  std::optional<FacesAround> around_;  ///< when Eq. 1 averages over them
  const std::size_t faces_;            ///< triangles, up to a multiple of kTrianglesAtOnce
  Buffer<std::uint32_t> corners_;      ///< three per triangle
  Buffer<std::uint32_t> across_;       ///< area_normals_ of the neighbours, when Eq. 1 is as printed
  Buffer<Row> area_normals_;
  Buffer<Row> planes_;
  double per_squared_scale_;
};

}  // namespace

double offset_coefficient(const AdaptiveParams& params, double x) {
  switch (params.coefficient) {
    case AdaptiveParams::Coefficient::Linear:
      return std::min(x, 1.0);
    case AdaptiveParams::Coefficient::Gaussian:
      return 1 - portable_exp(-x / (params.sigma * params.sigma));
    case AdaptiveParams::Coefficient::Exponential:
      break;
  }
  constexpr double kMost = 1.5, kLogOfMost = 0.405465108108164;
  return x >= kLogOfMost ? kMost : portable_exp(x);
}

Result<SmoothOutcome> smooth_adaptive(Surface& surface, const AdaptiveParams& params,
                                      const IterationOptions& options, const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  Adaptive adaptive(surface, params, constraints.movable(), run);
  return iterate(
      surface, constraints, options, run,
      {.prepare = [&](auto from) { return adaptive.prepare(from); },
       .move = [&](auto from, auto to, std::size_t begin, std::size_t) { adaptive.move(from, to, begin); }});
}

Method adaptive_method() {
  using P = AdaptiveParams;
  constexpr P kDefaults;
  return {
      .name = "adaptive",
      .summary =
          "Feature-preserving, adaptive, anisotropic smoothing: offsets along expected normals, scaled by "
          "how "
          "rough the place is.",
      .reference =
          "Feature-preserving, Adaptive and Anisotropic Smoothing Algorithm for Triangular Mesh Models, Eq. "
          "1 to 8",
      .formula =
          "v' = v + d V,  V = mean over triangles R at v of [vC . m(R)] m(R),  m(R) = sum A(S) n(S) / sum "
          "A(S),  "
          "d = g(|U(v)|^2 / scale^2)",
      .parameters = with_iteration_parameters({
          choice_parameter("normals", {"raw", "unit"},
                           "Expected normals of Eq. 1 as printed, or made unit vectors."),
          choice_parameter("neighbourhood", {"edges", "vertices"},
                           "Neighbours in Eq. 1: triangles across the edges (1-ring), or all that share a "
                           "vertex (2-ring)."),
          choice_parameter("offsets", {"uniform", "area"}, "Weights of the mean in Eq. 2."),
          choice_parameter("umbrella", {"uniform", "inverse_length"},
                           "Weights of the umbrella operator, Eq. 3."),
          choice_parameter("coefficient", {"exponential", "linear", "gaussian"},
                           "g of the offset coefficient: Eq. 6 (at most 1.5), Eq. 5 (at most 1) or Eq. 7."),
          number_parameter("sigma", kDefaults.sigma, 0.001, 100, "1",
                           "Sigma of Eq. 7; smaller reacts to less noise."),
          number_parameter("scale", kDefaults.scale, 0, 1e30, "mesh unit",
                           "Length that the umbrella vector is measured by; 0 means the mean edge length."),
      }),
      .work_memory = {.per_vertex = 115, .per_triangle = 75},
      .nanoseconds = 9,
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        P params;
        if (values.choice("normals") == "unit") params.normals = P::Normals::Unit;
        if (values.choice("neighbourhood") == "vertices") params.neighbourhood = P::Neighbourhood::Vertices;
        if (values.choice("offsets") == "area") params.offsets = P::Offsets::Area;
        if (values.choice("umbrella") == "inverse_length") params.umbrella = P::Umbrella::InverseLength;
        if (values.choice("coefficient") == "linear") params.coefficient = P::Coefficient::Linear;
        if (values.choice("coefficient") == "gaussian") params.coefficient = P::Coefficient::Gaussian;
        params.sigma = values.number("sigma");
        params.scale = values.number("scale");
        return smooth_adaptive(surface, params, iteration_options(values, surface), run);
      }};
}

}  // namespace burnish
