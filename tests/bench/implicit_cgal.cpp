#include <CGAL/Polygon_mesh_processing/smooth_shape.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include "tests/bench/compare.h"
#include "tests/bench/implicit.h"

namespace burnish::bench {

std::optional<ImplicitStep> cgal_step(const testing::Shape& shape, double time, double tolerance) {
  using Point = CGAL::Simple_cartesian<double>::Point_3;
  using Mesh = CGAL::Surface_mesh<Point>;
  using Matrix = CGAL::Eigen_sparse_matrix<double>::EigenType;
  using Solver =
      CGAL::Eigen_solver_traits<Eigen::BiCGSTAB<Matrix, Eigen::IncompleteLUT<double>>>;  // its default

  Mesh mesh;
  for (const Vec3d& p : shape.positions) mesh.add_vertex(Point(p.x, p.y, p.z));
  for (const auto& [a, b, c] : shape.triangles) {
    mesh.add_face(Mesh::Vertex_index(a), Mesh::Vertex_index(b), Mesh::Vertex_index(c));
  }
  const auto stays = mesh.add_property_map<Mesh::Vertex_index, bool>("v:stays", false).first;
  stays[Mesh::Vertex_index(0)] = stays[Mesh::Vertex_index(1)] = true;
  Solver solver;
  if (tolerance > 0) solver.solver().setTolerance(tolerance);

  ImplicitStep step;
  const double begin = thread_seconds();
  CGAL::Polygon_mesh_processing::smooth_shape(
      mesh, time,
      CGAL::parameters::number_of_iterations(1).vertex_is_constrained_map(stays).sparse_linear_solver(
          solver));
  step.seconds = thread_seconds() - begin;
  for (const auto v : mesh.vertices()) {
    const Point& p = mesh.point(v);
    step.positions.push_back({p.x(), p.y(), p.z()});
  }
  if (step.positions == shape.positions) return std::nullopt;
  return step;
}

}  // namespace burnish::bench
