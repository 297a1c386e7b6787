#include "core/smooth/adaptive.h"

#include <algorithm>

#include "core/run/math.h"
#include "core/run/parallel.h"
#include "core/smooth/parameters.h"
#include "core/smooth/umbrella.h"

namespace burnish {
namespace {

/// What Eq. 1 asks of a neighbour. Apart from Plane, so that each pass gathers only what it needs.
struct Face {
  SimdVec3 area_normal;  // cross product of two edges: normal times twice the area
  float twice_area = 0;
};

/// What Eq. 2 asks of a triangle at the vertex.
struct Plane {
  SimdVec3 expected_normal, centroid;
};

/// Below this share of the summed areas the weighted normals cancel out, and their sum is only rounding.
constexpr float kVanishing = 1e-6F;

class Adaptive {
 public:
  Adaptive(const Surface& surface, const AdaptiveParams& params, std::span<const std::uint8_t> movable,
           const RunControl& run)
      : surface_(surface),
        topology_(surface.topology),
        params_(params),
        movable_(movable),
        run_(run),
        faces_(surface.mesh.triangles.size()),
        planes_(surface.mesh.triangles.size()) {
    const double scale = params.scale > 0 ? params.scale / surface.mesh.frame.scale() : surface.mean_edge;
    per_squared_scale_ = scale > 0 ? 1 / (scale * scale) : 0;
  }

  bool prepare(std::span<const SimdVec3> from) {
    return for_each_face([&](std::size_t f) { measure(from, f); }) &&
           for_each_face([&](std::size_t f) { planes_[f].expected_normal = expected_normal(f); });
  }

  void move(std::span<const SimdVec3> from, std::span<SimdVec3> to, std::size_t begin,
            std::size_t end) const {
    for (std::size_t v = begin; v < end; ++v) {
      if (!movable_[v]) continue;
      const float d = static_cast<float>(coefficient(from, v));
      to[v] = from[v] + offset(from[v], v) * d;  // Eq. 8
    }
  }

 private:
  template <class Visit>
  bool for_each_face(Visit&& visit) {
    return parallel_for(faces_.size(), run_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) visit(f);
    });
  }

  void measure(std::span<const SimdVec3> from, std::size_t f) {
    const Triangle& t = surface_.mesh.triangles[f];
    const SimdVec3 a = from[t[0]], b = from[t[1]], c = from[t[2]];
    const SimdVec3 area_normal = cross(b - a, c - a);
    faces_[f] = {area_normal, length(area_normal)};
    planes_[f].centroid = (a + b + c) * (1.0F / 3.0F);
  }

  /// m(R), Eq. 1: sum of A(S) n(S) over sum of A(S); n(R) where the neighbours cancel out or there are none.
  SimdVec3 expected_normal(std::size_t f) const {
    SimdVec3 sum;
    float areas = 0;
    const auto add = [&](Index neighbour, bool opposed) {
      const Face& face = faces_[neighbour];
      if (opposed) {
        sum -= face.area_normal;
      } else {
        sum += face.area_normal;
      }
      areas += face.twice_area;
    };
    if (params_.neighbourhood == AdaptiveParams::Neighbourhood::Edges) {
      for (std::size_t side = 0; side < 3; ++side) {
        const Index neighbour = topology_.face_neighbours[f][side];
        if (neighbour != kNone) add(neighbour, topology_.opposed(f, side));
      }
    } else {
      for_each_vertex_neighbour(f, [&](Index neighbour) { add(neighbour, false); });
    }
    const float size = length(sum);
    if (size <= kVanishing * areas || areas == 0) {
      const Face& own = faces_[f];
      return own.twice_area > 0 ? own.area_normal * (1 / own.twice_area) : SimdVec3{};
    }
    return sum * (1 / (params_.normals == AdaptiveParams::Normals::Unit ? size : areas));
  }

  /// Each triangle that shares a vertex with f, once, f itself left out.
  template <class Visit>
  void for_each_vertex_neighbour(std::size_t f, Visit&& visit) const {
    const Triangle& t = surface_.mesh.triangles[f];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      for (const Index neighbour : topology_.vertex_faces[t[corner]]) {
        if (neighbour == f) continue;
        const Triangle& n = surface_.mesh.triangles[neighbour];
        const auto seen_at = [&](std::size_t c) { return n[0] == t[c] || n[1] == t[c] || n[2] == t[c]; };
        bool seen = false;
        for (std::size_t earlier = 0; earlier < corner; ++earlier) seen = seen || seen_at(earlier);
        if (!seen) visit(neighbour);
      }
    }
  }

  /// V, Eq. 2: the mean of [PC . m(R)] m(R) over the triangles R at P.
  SimdVec3 offset(SimdVec3 p, std::size_t v) const {
    SimdVec3 sum;
    float weights = 0;
    for (const Index f : topology_.vertex_faces[v]) {
      const float weight = params_.offsets == AdaptiveParams::Offsets::Area ? faces_[f].twice_area : 1.0F;
      const auto& [m, centroid] = planes_[f];
      sum += m * (weight * dot(centroid - p, m));
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
  std::span<const std::uint8_t> movable_;
  const RunControl& run_;
  std::vector<Face> faces_;
  std::vector<Plane> planes_;
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
  const Constraints constraints(surface, options.constraints);
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
