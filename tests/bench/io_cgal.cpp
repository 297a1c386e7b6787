#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO.h>
#include <CGAL/boost/graph/IO/OBJ.h>

#include "tests/bench/io_compare.h"

namespace burnish::bench {

FileSeconds cgal_file(const std::string& in, const std::string& out) {
  FileSeconds seconds;
  CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3> mesh;
  StageClock clock;
  CGAL::IO::read_OBJ(in, mesh);
  seconds.read = clock.lap();
  CGAL::IO::write_OBJ(out, mesh, CGAL::parameters::default_values());
  seconds.write = clock.lap();
  return seconds;
}

}  // namespace burnish::bench
