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

using Row = SimdVec3::Lanes;  // four floats

/// Below this share of the summed areas the weighted normals cancel out, and their sum is only rounding.
constexpr float kVanishing = 1e-6F;

/// With the normals and offsets that the kernels are made for, the vertices of one valence go there, and no
/// array of triangles is needed; any other choice first fills arrays of all of them, one at a time.
class Adaptive {
 public:
  Adaptive(const Surface& surface, const AdaptiveParams& params, std::span<const std::uint8_t> movable,
           const RunControl& run)
      : surface_(surface),
        topology_(surface.topology),
        params_(params),
        run_(run),
        plain_(params.normals == AdaptiveParams::Normals::Raw &&
               params.neighbourhood == AdaptiveParams::Neighbourhood::Edges &&
               params.offsets == AdaptiveParams::Offsets::Uniform),
        own_coefficient_(params.umbrella != AdaptiveParams::Umbrella::Uniform ||
                         params.coefficient != AdaptiveParams::Coefficient::Exponential),
        order_(plain_ ? ValenceOrder(surface.mesh.triangles, topology_, movable, run)
                      : ValenceOrder(topology_, movable, run)) {
    const double scale = params.scale > 0 ? params.scale / surface.mesh.frame.scale() : surface.mean_edge;
    per_squared_scale_ = scale > 0 ? 1 / (scale * scale) : 0;
    if (plain_) return;
    planes_.resize(surface.mesh.triangles.size());
    area_normals_.resize(planes_.size());
    if (params.neighbourhood == AdaptiveParams::Neighbourhood::Vertices) around_.emplace(surface, run);
  }

  bool prepare(std::span<const SimdVec3> from) {
    if (plain_) return true;
    const auto known = [&](std::size_t f) { return area_normals_[f]; };
    return for_each(planes_.size(), run_, [&](std::size_t f) { area_normals_[f] = area_normal(from, f); }) &&
           for_each(planes_.size(), run_, [&](std::size_t f) { planes_[f] = plane(from, f, known); });
  }

  void move(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
            std::size_t end) const {
    if (pays_to_fetch_ahead(from.size())) {
      for (std::size_t v = begin; v < end; v += 4) fetch_ahead(from, to, v);
    }
    order_.for_each_group(begin, [&](const ValenceOrder::Group& group) {
      if (plain_ && group.valence != ValenceOrder::kOther) {
        kernel_.move(group, own_coefficient_, static_cast<float>(per_squared_scale_), from, to);
        if (!own_coefficient_) return;
        for (const Index v : group.vertices)
          to[v] = from[v] + to[v] * static_cast<float>(coefficient(from, v));
        return;
      }
      for (const Index v : group.vertices) to[v] = moved(from, v);
    });
  }

 private:
  /// Eq. 8.
  SimdVec3 moved(std::span<const SimdVec3> from, Index v) const {
    return from[v] + offset(from, v) * static_cast<float>(coefficient(from, v));
  }

  /// Normal times twice the area, and twice the area.
  Row area_normal(std::span<const SimdVec3> from, std::size_t f) const {
    const Triangle& t = surface_.mesh.triangles[f];
    const SimdVec3 normal = cross(from[t[1]] - from[t[0]], from[t[2]] - from[t[0]]);
    return Row{normal.x(), normal.y(), normal.z(), length(normal)};
  }

  /// m(R), Eq. 1: sum of A(S) n(S) over sum of A(S); n(R) where the neighbours cancel out or there are none.
  /// `area_normal_of(f)` is asked for the neighbours' and for its own.
  template <class AreaNormals>
  SimdVec3 expected_normal(std::size_t f, const AreaNormals& area_normal_of) const {
    SimdVec3 sum;
    float areas = 0;
    const auto add = [&](Index neighbour, bool opposed) {
      const Row row = area_normal_of(neighbour);
      if (opposed) {
        sum -= normal(row);
      } else {
        sum += normal(row);
      }
      areas += row[3];
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
      const Row own = area_normal_of(f);
      return own[3] > 0 ? normal(own) * (1 / own[3]) : SimdVec3{};
    }
    return sum * (1 / (params_.normals == AdaptiveParams::Normals::Unit ? size : areas));
  }

  static SimdVec3 normal(const Row& row) { return {row[0], row[1], row[2]}; }

  /// (m, m . C), m the expected normal and C the centroid.
  template <class AreaNormals>
  Row plane(std::span<const SimdVec3> from, std::size_t f, const AreaNormals& area_normal_of) const {
    const Triangle& t = surface_.mesh.triangles[f];
    const SimdVec3 m = expected_normal(f, area_normal_of);
    return Row{m.x(), m.y(), m.z(), dot(m, (from[t[0]] + from[t[1]] + from[t[2]]) * (1.0F / 3.0F))};
  }

  /// V, Eq. 2: the mean of [PC . m(R)] m(R) over the triangles R at P.
  SimdVec3 offset(std::span<const SimdVec3> from, Index v) const {
    const auto unknown = [&](std::size_t f) { return area_normal(from, f); };
    SimdVec3 sum;
    float weights = 0;
    std::size_t count = 0;
    for (const Index f : topology_.vertex_faces[v]) {
      if (++count % kBlockSize == 0 && run_.stopped()) break;  // there may be millions
      const float weight = params_.offsets == AdaptiveParams::Offsets::Area ? area_normals_[f][3] : 1.0F;
      const Row row = plain_ ? plane(from, f, unknown) : planes_[f];
      sum += normal(row) * (weight * (row[3] - dot(from[v], normal(row))));
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
  const adaptive_kernels::Kernel& kernel_ = adaptive_kernels::kernel();
  bool plain_;            ///< the kernels are made for the normals and offsets
  bool own_coefficient_;  ///< but not for d
  ValenceOrder order_;
  std::optional<FacesAround> around_;  ///< when Eq. 1 averages over them
  Buffer<Row> area_normals_, planes_;  ///< of every triangle, unless it is plain
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
  return iterate(surface, constraints, options, run,
                 {.prepare = [&](auto from) { return adaptive.prepare(from); },
                  .move = [&](auto from, auto to, std::size_t begin,
                              std::size_t end) { adaptive.move(from, to, begin, end); }});
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
      .nanoseconds = 7,
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
