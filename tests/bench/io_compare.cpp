// Files beside public libraries, those of them that are installed, in one process.
//   io_compare MESH.obj [BURNISH]
// Prints milliseconds, the least of a few runs, to read the file with its topology and to write the smoothed
// mesh: ours on one thread and on all cores (the libraries have one), and how often each fits into theirs;
// then file to file with 20 smoothing steps. BURNISH, the command
// line program, is timed from its start to its end, with all cores, report included; the libraries are
// single-threaded, so their CPU time is what a program around them takes at least.
#include "tests/bench/io_compare.h"

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/io/codec.h"
#include "core/smooth/taubin.h"

namespace burnish::bench {
namespace {

constexpr int kRuns = 20;

std::string whole_file(const std::string& path) {
  std::string text(std::filesystem::file_size(path), '\0');
  std::ifstream(path, std::ios::binary).read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
}

FileSeconds our_file(const std::string& in, const std::string& out, unsigned threads) {
  const Limits limits{.max_bytes = ~std::uint64_t{0}};
  const RunControl run{.threads = threads};
  FileSeconds seconds;
  StageClock clock(threads == 1 ? thread_seconds : wall_seconds);
  const std::string text = whole_file(in);
  const auto document = decode(text, Format::Obj, limits, run);
  if (!document) {
    std::fprintf(stderr, "%s: %s\n", in.c_str(), document.error().message.c_str());
    std::exit(2);
  }
  auto surface = std::move(*prepare_surface((*document)->positions(), (*document)->triangles(), run));
  seconds.read = clock.lap();
  const auto before = surface.mesh.positions;
  if (!smooth_taubin(surface, {}, {.iterations = kCompareIterations}, run)) std::abort();
  seconds.smooth = clock.lap();
  const MovedPositions moved{(*document)->positions(), surface.weld, before, surface.mesh.positions,
                             surface.mesh.frame};
  const auto written = encode(**document, moved, {}, run);
  std::ofstream(out, std::ios::binary)
      .write(written->bytes.data(), static_cast<std::streamsize>(written->bytes.size()));
  seconds.write = clock.lap();
  return seconds;
}

FileSeconds on_one_thread(const std::string& in, const std::string& out) { return our_file(in, out, 1); }
FileSeconds on_all_cores(const std::string& in, const std::string& out) { return our_file(in, out, 0); }

FileSeconds least(FileSeconds (*run)(const std::string&, const std::string&), const std::string& in,
                  const std::string& out) {
  FileSeconds best = run(in, out);
  for (int i = 1; i < kRuns; ++i) {
    const FileSeconds now = run(in, out);
    best = {std::min(best.read, now.read), std::min(best.smooth, now.smooth),
            std::min(best.write, now.write)};
  }
  return best;
}

double program_seconds(const std::string& program, const std::string& in, const std::string& out) {
  const std::string command = program + " smooth '" + in + "' '" + out + "' --method taubin --iterations " +
                              std::to_string(kCompareIterations) + " > /dev/null";
  double best = 1e9;
  for (int i = 0; i < kRuns; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    if (std::system(command.c_str()) != 0) std::exit(2);
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

void compare(const std::string& in, const char* program) {
  const std::string out = (std::filesystem::temp_directory_path() / "burnish_io_compare.obj").string();
  const FileSeconds one = least(on_one_thread, in, out), all = least(on_all_cores, in, out);
  const double whole = program != nullptr ? program_seconds(program, in, out) : 0;
  const auto row = [&](const char* name, const FileSeconds& theirs, bool smooths) {
    std::printf("%-16s read %8.2f ms (%5.2f x one thread, %5.2f x all)   write %8.2f ms (%5.2f x, %5.2f x)",
                name, theirs.read * 1e3, theirs.read / one.read, theirs.read / all.read, theirs.write * 1e3,
                theirs.write / one.write, theirs.write / all.write);
    if (smooths && whole > 0) {
      const double sum = theirs.read + theirs.smooth + theirs.write;
      std::printf("   file to file %8.0f ms (%5.2f x burnish)", sum * 1e3, sum / whole);
    }
    std::printf("\n");
  };
  row("ours, one thread", one, false);
  row("ours, all cores", all, false);
  if (whole > 0) std::printf("%-16s file to file %.0f ms\n", "burnish", whole * 1e3);
#ifdef BURNISH_HAS_OPENMESH
  row("OpenMesh", least(openmesh_file, in, out), true);
#endif
#ifdef BURNISH_HAS_CGAL
  row("CGAL", least(cgal_file, in, out), false);
#endif
#ifdef BURNISH_HAS_VTK
  row("VTK", least(vtk_file, in, out), true);
#endif
  std::filesystem::remove(out);
}

}  // namespace
}  // namespace burnish::bench

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: io_compare MESH.obj [BURNISH]\n");
    return 2;
  }
  // For all of them: memory that was given back is used again, so that no run pays for the system's clearing
  // of pages.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
  burnish::bench::compare(arguments[1], count > 2 ? arguments[2] : nullptr);
}
