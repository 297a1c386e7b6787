#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkOBJWriter.h>
#include <vtkPolyData.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include "tests/bench/io_compare.h"

namespace burnish::bench {

FileSeconds vtk_file(const std::string& in, const std::string& out) {
  FileSeconds seconds;
  StageClock clock;
  vtkNew<vtkOBJReader> reader;
  reader->SetFileName(in.c_str());
  reader->Update();
  reader->GetOutput()->BuildLinks();
  seconds.read = clock.lap();
  vtkNew<vtkWindowedSincPolyDataFilter> filter;
  filter->SetInputData(reader->GetOutput());
  filter->SetNumberOfIterations(kCompareIterations);
  filter->Update();
  seconds.smooth = clock.lap();
  vtkNew<vtkOBJWriter> writer;
  writer->SetFileName(out.c_str());
  writer->SetInputData(filter->GetOutput());
  writer->Write();
  seconds.write = clock.lap();
  return seconds;
}

}  // namespace burnish::bench
