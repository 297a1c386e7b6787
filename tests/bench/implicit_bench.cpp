// One step of implicit mean curvature flow, ours beside Eigen's SimplicialLDLT and ConjugateGradient used
// plainly (double, triplets, three columns) and, when it is installed (apt-get install libcgal-dev), CGAL's
// smooth_shape. Same process, one thread, CPU time of assembly and solution, the least of a few runs.
//   implicit_bench [MESH.obj...]   without a mesh: noisy rings of 20k, 70k and 280k triangles
// Residuals are |b - A x| / |b|, b = M X, in double; Eigen's and CGAL's iterations stop at the one that ours
// reached. CGAL builds another matrix (cotangents as they are), so its residual is only what it was told.
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "core/io/codec.h"
#include "core/smooth/registry.h"
#include "tests/bench/compare.h"
#include "tests/bench/implicit.h"
#include "tests/bench/meshes.h"

namespace burnish::bench {
namespace {

using testing::Shape;
using Matrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::MatrixX3d;

constexpr double kLargestCotangent = 10;

struct System {
  Matrix matrix;
  Columns right;
};

/// M - dt L and M X, as [4] writes them.
System assemble(const Shape& shape, double time) {
  const auto n = static_cast<Eigen::Index>(shape.positions.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(n);
  for (const Triangle& t : shape.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Index a = t[(c + 1) % 3], b = t[(c + 2) % 3];
      const Vec3d p = shape.positions[a] - shape.positions[t[c]],
                  q = shape.positions[b] - shape.positions[t[c]];
      const double twice_area = length(cross(p, q));
      const double weight = time * 0.5 * std::clamp(dot(p, q) / twice_area, 0.0, kLargestCotangent);
      entries.emplace_back(a, b, -weight);
      entries.emplace_back(b, a, -weight);
      entries.emplace_back(a, a, weight);
      entries.emplace_back(b, b, weight);
      entries.emplace_back(t[c], t[c], twice_area / 6);
      mass[t[c]] += twice_area / 6;
    }
  }
  System system{Matrix(n, n), Columns(n, 3)};
  system.matrix.setFromTriplets(entries.begin(), entries.end());
  for (Eigen::Index v = 0; v < n; ++v) {
    const Vec3d& p = shape.positions[static_cast<std::size_t>(v)];
    system.right.row(v) << mass[v] * p.x, mass[v] * p.y, mass[v] * p.z;
  }
  return system;
}

Columns columns(const std::vector<Vec3d>& positions) {
  Columns x(static_cast<Eigen::Index>(positions.size()), 3);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    x.row(static_cast<Eigen::Index>(v)) << positions[v].x, positions[v].y, positions[v].z;
  }
  return x;
}

struct Step {
  double seconds = 0;
  Columns positions;
};

Step ours(const Surface& start, double time_step, const char* solver) {
  const Method& method = **find_method("implicit_mean_curvature_flow");
  const auto values = resolve_parameters(method, {{"iterations", std::int64_t{1}},
                                                  {"time_step", time_step},
                                                  {"largest_cotangent", kLargestCotangent},
                                                  {"solver", std::string(solver)},
                                                  {"boundary", std::string("free")}});
  Surface surface = start;
  Step step;
  const double begin = thread_seconds();
  const auto outcome = method.run(surface, *values, {});
  step.seconds = thread_seconds() - begin;
  if (!outcome) std::abort();
  for (const Warning& warning : outcome->warnings) {
    if (warning.code == "solver_changed") return {};
  }
  std::vector<Vec3d> moved;
  for (const Index v : surface.weld) {
    moved.push_back(surface.mesh.frame.to_file(to_double(surface.mesh.positions[v])));
  }
  step.positions = columns(moved);
  return step;
}

Step eigen_cholesky(const Shape& shape, double time) {
  const double begin = thread_seconds();
  const System system = assemble(shape, time);
  const Eigen::SimplicialLDLT<Matrix> solver(system.matrix);
  Step step{0, solver.solve(system.right)};
  step.seconds = thread_seconds() - begin;
  return step;
}

Step eigen_gradients(const Shape& shape, double time, double tolerance) {
  const Columns guess = columns(shape.positions);
  const double begin = thread_seconds();
  const System system = assemble(shape, time);
  Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper> solver(system.matrix);
  solver.setTolerance(tolerance);
  Step step{0, solver.solveWithGuess(system.right, guess)};
  step.seconds = thread_seconds() - begin;
  return step;
}

Step least(int runs, const std::function<Step()>& measure) {
  Step best = measure();
  for (int i = 1; i < runs; ++i) {
    Step next = measure();
    if (next.seconds < best.seconds) best = std::move(next);
  }
  return best;
}

void compare(const Shape& shape) {
  const Surface surface = testing::surface_of(shape);
  const double h = surface.mean_edge * surface.mesh.frame.scale();
  const int runs = shape.positions.size() > 100'000 ? 2 : 5;
  std::printf("\n%zu vertices, %zu triangles\n", shape.positions.size(), shape.triangles.size());
  if (surface.mesh.positions.size() != shape.positions.size()) std::exit(2);  // vertices would not correspond
  for (const double time_step : {0.1, 1.0, 10.0, 1000.0}) {
    const double time = time_step * h * h;
    const System system = assemble(shape, time);
    const auto residual = [&](const Columns& x) {
      return (system.right - system.matrix * x).norm() / system.right.norm();
    };
    std::printf(" time step %g h^2%19s ms  ratio  residual\n", time_step, "");
    const Step base = least(runs, [&] { return ours(surface, time_step, "conjugate_gradients"); });
    const auto row = [&](const char* name, const Step& step) {
      if (step.positions.rows() == 0) return std::printf("  %-28s refused\n", name);
      return std::printf("  %-28s %9.2f %6.2f  %.1e\n", name, step.seconds * 1e3, step.seconds / base.seconds,
                         residual(step.positions));
    };
    row("ours, conjugate gradients", base);
    row("ours, cholesky", least(runs, [&] { return ours(surface, time_step, "cholesky"); }));
    row("ours, auto", least(runs, [&] { return ours(surface, time_step, "auto"); }));
    const double reached = residual(base.positions);
    row("Eigen ConjugateGradient", least(runs, [&] { return eigen_gradients(shape, time, reached); }));
    row("Eigen SimplicialLDLT", least(std::min(runs, 2), [&] { return eigen_cholesky(shape, time); }));
#ifdef BURNISH_HAS_CGAL
    for (const double tolerance : {reached, 0.0}) {
      const char* name = tolerance > 0 ? "CGAL smooth_shape" : "CGAL, its own tolerance";
      if (const auto step = cgal_step(shape, time, tolerance)) {
        std::printf("  %-28s %9.2f %6.2f\n", name, step->seconds * 1e3, step->seconds / base.seconds);
      } else {
        std::printf("  %-28s gave up\n", name);
      }
    }
#endif
  }
}

Shape load(const char* path) {
  const std::string text = testing::read_file(path);
  const auto document = decode(text, Format::Obj, {}, {});
  if (!document) {
    std::fprintf(stderr, "%s: %s\n", path, document.error().message.c_str());
    std::exit(2);
  }
  return {{(*document)->positions().begin(), (*document)->positions().end()},
          {(*document)->triangles().begin(), (*document)->triangles().end()}};
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  using namespace burnish::bench;
  for (int i = 1; i < count; ++i) compare(load(arguments[i]));
  if (count < 2) {
    for (const int size : {kSizes[0], kSizes[1], kSizes[2]}) compare(noisy_mesh(size));
  }
}
