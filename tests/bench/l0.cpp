#include "tests/bench/l0.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "core/run/math.h"
#include "core/smooth/parameters.h"

namespace burnish::bench {
namespace {

constexpr double kFirstBeta = 1e-3, kLastBeta = 1e3;
constexpr std::array<double, 4> kRegulariser = {1, -1, 1, -1};

using Corners = std::array<Index, 4>;  // as in EdgeCorners

std::vector<Corners> inner_edges(const Surface& surface) {
  std::vector<Corners> edges;
  edges.reserve(surface.topology.adjacent_pairs());
  for (Index f = 0; f < surface.mesh.triangles.size(); ++f) {
    const Triangle& t = surface.mesh.triangles[f];
    for (std::size_t side = 0; side < 3; ++side) {
      const Index across = surface.topology.face_neighbours[f][side];
      if (across == kNone || across < f) continue;
      const Index a = t[side], b = t[(side + 1) % 3];
      const auto far =
          std::ranges::find_if(surface.mesh.triangles[across], [&](Index v) { return v != a && v != b; });
      edges.push_back({a, t[(side + 2) % 3], b, *far});
    }
  }
  return edges;
}

/// Between the normals of the two triangles, in radians.
double turn(const EdgeCorners& p) {
  const Vec3d edge = p[2] - p[0], n = cross(edge, p[1] - p[0]), m = cross(p[3] - p[0], edge);
  return portable_angle(length(cross(n, m)), dot(n, m));
}

Vec3d applied(const std::array<double, 4>& weights, const EdgeCorners& p) {
  return weights[0] * p[0] + weights[1] * p[1] + weights[2] * p[2] + weights[3] * p[3];
}

class L0Steps {
 public:
  L0Steps(const Surface& surface, const L0Params& params, std::span<const std::uint8_t> movable,
          const RunControl& run)
      : home_(surface.mesh.positions),
        edges_(inner_edges(surface)),
        unknown_(home_.size(), kNone),
        run_(run),
        least_(1e-8 * surface.mean_edge * surface.mean_edge),
        mu_(params.mu) {
    for (std::size_t v = 0; v < home_.size(); ++v) {
      if (movable[v] != 0) unknown_[v] = unknowns_++;
    }
    double mean_turn = 0;
    for (const Corners& edge : edges_) {
      mean_turn += turn(at(home_, edge)) / static_cast<double>(edges_.size());
    }
    lambda_ = params.lambda * surface.mean_edge * surface.mean_edge * mean_turn;
    alpha_ = params.alpha * mean_turn;
    make_pattern();
  }

  bool prepare(std::span<const SimdVec3> from) {
    std::ranges::fill(std::span(matrix_.valuePtr(), static_cast<std::size_t>(matrix_.nonZeros())), 0.0);
    for (std::size_t v = 0; v < home_.size(); ++v) {
      if (unknown_[v] == kNone) continue;
      matrix_.coeffRef(unknown_[v], unknown_[v]) = 1;
      right_.row(unknown_[v]) << double{home_[v].x}, double{home_[v].y}, double{home_[v].z};
    }
    for (const Corners& edge : edges_) {
      const EdgeCorners p = at(from, edge);
      const std::array<double, 4> weights = edge_operator(p, least_);
      const Vec3d bend = applied(weights, p);
      add(edge, beta_, weights, dot(bend, bend) > lambda_ / beta_ ? bend : Vec3d{});
      if (alpha_ > 0) add(edge, alpha_, kRegulariser, {});
    }
    if (run_.stopped()) return false;
    solver_.factorize(matrix_);
    if (solver_.info() == Eigen::Success) {
      solution_ = solver_.solve(right_);
    } else {
      solution_.setConstant(NAN);  // diverged
    }
    beta_ *= mu_;
    alpha_ /= 2;
    return !run_.stopped();
  }

  void move(std::span<SimdVec3> to, std::size_t begin, std::size_t end) const {
    for (std::size_t v = begin; v < end; ++v) {
      if (unknown_[v] == kNone) continue;
      const auto row = solution_.row(unknown_[v]);
      to[v] = SimdVec3(to_float(Vec3d{row[0], row[1], row[2]}));
    }
  }

 private:
  static Vec3d point(const Vec3f& p) { return to_double(p); }
  static Vec3d point(const SimdVec3& p) { return to_double(p.vec3()); }
  template <class Positions>
  static EdgeCorners at(const Positions& p, const Corners& edge) {
    return {point(p[edge[0]]), point(p[edge[1]]), point(p[edge[2]]), point(p[edge[3]])};
  }

  /// Every pair of corners of an edge, in the lower triangle.
  void make_pattern() {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index u = 0; u < unknowns_; ++u) entries.emplace_back(u, u, 1);
    for (const Corners& edge : edges_) {
      for (const Index v : edge) {
        for (const Index w : edge) {
          const Index row = unknown_[v], column = unknown_[w];
          if (row != kNone && column != kNone && row > column) entries.emplace_back(row, column, 0);
        }
      }
    }
    matrix_.resize(unknowns_, unknowns_);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    right_.resize(unknowns_, 3);
    solution_.resize(unknowns_, 3);
    solver_.analyzePattern(matrix_);
  }

  /// factor |sum of weights times corners - target|^2, where corners that stay are numbers.
  void add(const Corners& edge, double factor, const std::array<double, 4>& weights, Vec3d target) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (unknown_[edge[i]] == kNone) target -= weights[i] * point(home_[edge[i]]);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const Index row = unknown_[edge[i]];
      if (row == kNone) continue;
      const double weight = factor * weights[i];
      right_.row(row) += weight * Eigen::RowVector3d(target.x, target.y, target.z);
      for (std::size_t j = 0; j < 4; ++j) {
        const Index column = unknown_[edge[j]];
        if (column != kNone && row >= column) matrix_.coeffRef(row, column) += weight * weights[j];
      }
    }
  }

  const std::vector<Vec3f>& home_;
  std::vector<Corners> edges_;
  std::vector<Index> unknown_;  // row in the system; kNone: it stays
  const RunControl& run_;
  double least_, mu_, lambda_ = 0, alpha_ = 0, beta_ = kFirstBeta;
  Index unknowns_ = 0;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::MatrixX3d right_, solution_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

Method make_method() {
  constexpr L0Params kDefaults;
  return {
      .name = "l0",
      .summary = "Looks for the mesh near the input that has the fewest bent edges.",
      .reference =
          "L. He, S. Schaefer, Mesh denoising via L0 minimization, ACM Transactions on Graphics 32 "
          "(SIGGRAPH 2013) 64:1-64:8",
      .formula = "minimum of |p - input|^2 + lambda (number of edges with D(e) p != 0)",
      .parameters = with_iteration_parameters(
          {number_parameter("lambda", kDefaults.lambda, 0, 1000,
                            "squared mean edge lengths times the mean angle", "What a bent edge costs."),
           number_parameter("alpha", kDefaults.alpha, 0, 1000, "the mean angle",
                            "Weight of the regulariser in the first iteration; it is halved in each."),
           number_parameter("mu", kDefaults.mu, 1.01, 10, "1", "Growth of beta per iteration.")},
          kMostIterations),
      .run = [](Surface& surface, const ParameterValues& values, const RunControl& run) {
        return smooth_l0(
            surface,
            {.lambda = values.number("lambda"), .alpha = values.number("alpha"), .mu = values.number("mu")},
            iteration_options(values, surface), run);
      }};
}

}  // namespace

std::array<double, 4> edge_operator(const EdgeCorners& p, double least) {
  const Vec3d edge = p[2] - p[0];
  const double squared = dot(edge, edge), left = length(cross(edge, p[1] - p[0])),
               right = length(cross(edge, p[3] - p[0]));  // twice the areas
  if (!(squared > least) || !(left + right > least)) return {};
  // Weighted by the area on the other side, the two far corners meet on the edge if all is flat.
  const double second = right / (left + right), fourth = left / (left + right);
  const double along = (second * dot(p[1] - p[0], edge) + fourth * dot(p[3] - p[0], edge)) / squared;
  return {along - 1, second, -along, fourth};
}

Result<SmoothOutcome> smooth_l0(Surface& surface, const L0Params& params, const IterationOptions& options,
                                const RunControl& run) {
  const Constraints constraints(surface, options.constraints, run);
  L0Steps steps(surface, params, constraints.movable(), run);
  IterationOptions bounded = options;
  const double growths = std::ceil(std::log(kLastBeta / kFirstBeta) / std::log(params.mu));
  bounded.iterations = std::min(options.iterations, static_cast<std::uint32_t>(growths));
  return iterate(
      surface, constraints, bounded, run,
      {.prepare = [&](auto from) { return steps.prepare(from); },
       .move = [&](auto, auto to, std::size_t begin, std::size_t end) { steps.move(to, begin, end); }});
}

const Method& l0_method() {
  static const Method kMethod = make_method();
  return kMethod;
}

}  // namespace burnish::bench
