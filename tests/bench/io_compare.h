// Public libraries that read, smooth and write OBJ files, behind one signature. Each is in a file of its own,
// because their headers take long to compile.
#pragma once

#include <string>

#include "tests/bench/compare.h"

namespace burnish::bench {

/// Seconds of this thread's time (or, where several work, of the clock on the wall): to read a file with its
/// topology, for 20 smoothing steps, to write the result.
struct FileSeconds {
  double read = 0, smooth = 0, write = 0;
};

/// Times three things in turn.
class StageClock {
 public:
  explicit StageClock(double (*now)() = thread_seconds) : now_(now) {}
  double lap() {
    const double start = last_;
    last_ = now_();
    return last_ - start;
  }

 private:
  double (*now_)();
  double last_ = now_();
};

/// TriMesh_ArrayKernelT, JacobiLaplaceSmootherT.
FileSeconds openmesh_file(const std::string& in, const std::string& out);
/// Surface_mesh over Simple_cartesian<double>; CGAL has no linear filter, so nothing is smoothed.
FileSeconds cgal_file(const std::string& in, const std::string& out);
/// vtkOBJReader and the cells' links, vtkWindowedSincPolyDataFilter, vtkOBJWriter.
FileSeconds vtk_file(const std::string& in, const std::string& out);

}  // namespace burnish::bench
