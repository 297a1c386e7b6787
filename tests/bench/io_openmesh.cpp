#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Smoother/JacobiLaplaceSmootherT.hh>

#include "tests/bench/io_compare.h"

namespace burnish::bench {

FileSeconds openmesh_file(const std::string& in, const std::string& out) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  FileSeconds seconds;
  Mesh mesh;
  StageClock clock;
  OpenMesh::IO::read_mesh(mesh, in);
  seconds.read = clock.lap();
  OpenMesh::Smoother::JacobiLaplaceSmootherT<Mesh> smoother(mesh);
  smoother.initialize(OpenMesh::Smoother::SmootherT<Mesh>::Tangential_and_Normal,
                      OpenMesh::Smoother::SmootherT<Mesh>::C0);
  smoother.smooth(kCompareIterations);
  seconds.smooth = clock.lap();
  OpenMesh::IO::write_mesh(mesh, out);
  seconds.write = clock.lap();
  return seconds;
}

}  // namespace burnish::bench
