#include "core/smooth/sparse_system.h"

#include <algorithm>
#include <cmath>

#include "core/smooth/parameters.h"

namespace burnish {
namespace {

using Kind = SolverOptions::Kind;

template <std::size_t kValence>
void multiply_group(std::span<const Index> vertices, const IndexRows& neighbours, const float* diagonal,
                    const float* weights, const SimdVec3* p, SimdVec3* q) {
  for (const Index v : vertices) {
    const std::size_t start = neighbours.offsets[v];
    const Index* const row = neighbours.items.data() + start;
    const float* const weight = weights + start;
    SimdVec3 sum = p[v] * diagonal[v];
    for (std::size_t k = 0; k < kValence; ++k) sum -= p[row[k]] * weight[k];
    q[v] = sum;
  }
}

/// With a multigrid preconditioner, conjugate gradients take as long as about so many iterations without.
constexpr double kMultigridIterations = 130;

}  // namespace

SparseSystem::SparseSystem(const Surface& surface, std::span<const std::uint8_t> movable,
                           const SolverOptions& options, const RunControl& run)
    : surface_(surface),
      offsets_(surface.topology.vertex_neighbours.offsets),
      movable_(movable),
      options_(options),
      run_(run),
      unknowns_(static_cast<std::size_t>(std::ranges::count(movable, std::uint8_t{1}))),
      order_(surface.topology, movable, run),
      weights_(surface.topology.vertex_neighbours.items.size()),
      mass_(movable.size()),
      diagonal_(movable.size()),
      inverse_diagonal_(movable.size()),
      inverse_mass_(movable.size()),
      pull_(movable.size()),
      way_(movable.size()),
      sums_(movable.size()),
      gradients_(movable.size()) {}

void SparseSystem::finish_row(std::size_t v, std::span<const float> weights, std::span<const SimdVec3> from) {
  const Index* const neighbours = surface_.topology.vertex_neighbours.items.data() + offsets_[v];
  SimdVec3 pull;
  float total = mass_[v];
  for (std::size_t k = 0; k < weights.size(); ++k) {
    pull += (from[neighbours[k]] - from[v]) * weights[k];
    total += weights[k];
  }
  pull_[v] = pull;
  diagonal_[v] = total;
  inverse_diagonal_[v] = 1 / total;
  inverse_mass_[v] = 1 / mass_[v];
}

void SparseSystem::multiply(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin) const {
  const IndexRows& neighbours = surface_.topology.vertex_neighbours;
  order_.for_each_group(begin, [&](const ValenceOrder::Group& group) {
    with_constant_valence(group.valence, [&]<std::size_t kValence>() {
      multiply_group<kValence>(group.vertices, neighbours, diagonal_.data(), weights_.data(), p.data(),
                               q.data());
    });
    if (group.valence != ValenceOrder::kOther) return;
    for (const Index v : group.vertices) {
      SimdVec3 sum = p[v] * diagonal_[v];
      for (Index k = offsets_[v]; k < offsets_[v + 1]; ++k) sum -= p[neighbours.items[k]] * weights_[k];
      q[v] = sum;
    }
  });
}

bool SparseSystem::solve_assembled(double total_mass, double total_diagonal) {
  if (unknowns_ == 0) return true;
  const bool direct = prefers_cholesky(total_diagonal / total_mass);
  if (run_.stopped()) return false;
  if (direct && solve_by_cholesky()) return !run_.stopped();
  ++gradients_used_;
  const double distance = options_.tolerance * surface_.mean_edge;
  const auto report = solve_by_gradients(total_diagonal / total_mass, distance * distance * total_mass);
  if (!report) return false;
  if (report->converged) return true;
  const bool may_change = options_.kind == Kind::Auto && !direct && may_factorise();
  if (!may_change || !solve_by_cholesky()) ++not_converged_;
  return !run_.stopped();
}

std::optional<ConjugateGradientsReport> SparseSystem::solve_by_gradients(double diagonal_over_mass,
                                                                         double enough) {
  struct Plain {
    const SparseSystem& system;
    void operator()(std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin,
                    std::size_t) const {
      system.multiply(p, q, begin);
    }
  };
  struct Preconditioned : Plain {
    Multigrid& multigrid;
    bool precondition(std::span<const SimdVec3> r, std::span<SimdVec3> z) const {
      return multigrid.apply(r, z, system.run_);
    }
  };
  const SystemDiagonals diagonals{inverse_diagonal_, inverse_mass_};
  if (expected_iterations(diagonal_over_mass) < kMultigridIterations) {
    return gradients_.solve(Plain{*this}, diagonals, pull_, way_, enough, options_.most_iterations, run_);
  }
  if (!multigrid_) multigrid_.emplace();
  const bool built = multigrid_->build(
      surface_.topology.vertex_neighbours, weights_, diagonal_,
      [this](std::span<const SimdVec3> p, std::span<SimdVec3> q, std::size_t begin) {
        multiply(p, q, begin);
      },
      run_);
  if (!built) return std::nullopt;
  return gradients_.solve(Preconditioned{{*this}, *multigrid_}, diagonals, pull_, way_, enough,
                          options_.most_iterations, run_);
}

/// Of plain conjugate gradients, as measured on scans and spheres.
double SparseSystem::expected_iterations(double diagonal_over_mass) const {
  return std::min(8 * std::sqrt(diagonal_over_mass), 4 * std::sqrt(static_cast<double>(unknowns_)));
}

/// Compares nanoseconds per vertex, as measured on scans and spheres.
bool SparseSystem::prefers_cholesky(double diagonal_over_mass) {
  if (options_.kind == Kind::ConjugateGradients) return false;
  if (options_.kind == Kind::Cholesky) return may_factorise();
  const double n = static_cast<double>(unknowns_);
  const double gradients = 8 * std::min(kMultigridIterations, expected_iterations(diagonal_over_mass));
  constexpr double kAnalysis = 650, kSolution = 200;
  return gradients > kAnalysis + kSolution && may_factorise() &&
         gradients > kSolution + cholesky_->operations() / (3 * n);
}

bool SparseSystem::may_factorise() {
  if (unknowns_ > kMostCholeskyVertices) return false;
  if (!cholesky_) cholesky_.emplace(surface_.topology, movable_);
  return cholesky_->operations() <= kMostCholeskyOperations;
}

bool SparseSystem::solve_by_cholesky() { return cholesky_->solve(weights_, mass_, pull_, way_); }

void SparseSystem::warn(std::vector<Warning>& warnings) const {
  if (options_.kind == Kind::Cholesky && gradients_used_ > 0) {
    warnings.push_back(
        {"solver_changed",
         "Cholesky would take too long to answer a stop, or broke down; conjugate gradients solved instead",
         gradients_used_});
  }
  if (not_converged_ > 0) {
    warnings.push_back({"not_converged",
                        "conjugate gradients did not reach the tolerance in " +
                            std::to_string(options_.most_iterations) +
                            " iterations; their last result is used",
                        not_converged_});
  }
}

Result<SmoothOutcome> iterate_system(Surface& surface, const Constraints& constraints,
                                     const IterationOptions& options, const RunControl& run,
                                     const SparseSystem& system,
                                     std::function<bool(std::span<const SimdVec3> from)> prepare) {
  auto outcome = iterate(
      surface, constraints, options, run,
      {.prepare = std::move(prepare), .move = [&](auto from, auto to, std::size_t begin, std::size_t end) {
         for (std::size_t v = begin; v < end; ++v) {
           if (constraints.movable()[v] != 0) to[v] = from[v] + system.way()[v];
         }
       }});
  if (outcome) system.warn(outcome->warnings);
  return outcome;
}

std::vector<ParameterSpec> with_solver_parameters(std::vector<ParameterSpec> own) {
  constexpr SolverOptions kDefaults;
  constexpr std::uint32_t kIterations = 5;
  own.push_back(choice_parameter("solver", {"auto", "conjugate_gradients", "cholesky"},
                                 "How the linear system is solved; auto takes what is expected to be faster. "
                                 "Cholesky suits small meshes and long steps."));
  own.push_back(number_parameter("tolerance", kDefaults.tolerance, 1e-6, 0.1, "mean edge lengths",
                                 "Bound on the root mean square distance to the system's exact solution; "
                                 "only conjugate gradients need it."));
  return with_iteration_parameters(std::move(own), kIterations);
}

SolverOptions solver_options(const ParameterValues& values) {
  const std::string& solver = values.choice("solver");
  return {.kind = solver == "cholesky"              ? Kind::Cholesky
                  : solver == "conjugate_gradients" ? Kind::ConjugateGradients
                                                    : Kind::Auto,
          .tolerance = values.number("tolerance")};
}

}  // namespace burnish
