#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Smoother/JacobiLaplaceSmootherT.hh>
#include <vector>

#include "tests/bench/compare.h"

namespace burnish::bench {

#ifdef NDEBUG
double openmesh_seconds(
#else
double openmesh_asserting_seconds(
#endif
    std::span<const Vec3f> positions, std::span<const Triangle> triangles, int order) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  Mesh mesh;
  std::vector<Mesh::VertexHandle> handles;
  handles.reserve(positions.size());
  for (const Vec3f& p : positions) handles.push_back(mesh.add_vertex({p.x, p.y, p.z}));
  for (const Triangle& t : triangles) mesh.add_face(handles[t[0]], handles[t[1]], handles[t[2]]);
  OpenMesh::Smoother::JacobiLaplaceSmootherT<Mesh> smoother(mesh);
  using Smoother = OpenMesh::Smoother::SmootherT<Mesh>;
  smoother.initialize(Smoother::Tangential_and_Normal, order == 1 ? Smoother::C0 : Smoother::C1);
  const double start = thread_seconds();
  smoother.smooth(kCompareIterations);
  return thread_seconds() - start;
}

}  // namespace burnish::bench
