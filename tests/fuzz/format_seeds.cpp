// Writes a small mesh as a file of a format into a folder, for the fuzzer to start from: binary seeds are
// made, not committed.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/io/codec.h"

namespace {

using namespace burnish;

constexpr std::string_view kMesh =
    "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\n"
    "vt 0 0\nvt 1 0\nvt 0 1\nvn 0.6 0 0.8\nvn 0 1 0\n"
    "f 1/1/1 3/2/1 2/3/1\nf 1/1/2 2/2/2 4/3/1\nf 2/1/1 3/2/2 4/3/1\nf 3//1 1//1 4//1\n";

}  // namespace

int main(int argc, char** argv) {
  const auto format = argc == 3 ? format_named(argv[1]) : std::nullopt;
  if (!format) {
    std::fputs("usage: format_seeds FORMAT FOLDER\n", stderr);
    return 2;
  }
  const RunControl run;
  const auto document = decode(kMesh, Format::Obj, {}, run);
  const auto surface = prepare_surface((*document)->positions(), (*document)->triangles(), run);
  const std::vector<Vec3f>& same = surface->mesh.positions;
  const MovedPositions moved{(*document)->positions(), surface->weld, same, same, surface->mesh.frame};
  const auto encoded = encode(**document, moved, {.format = format}, run);
  if (!encoded) return 1;
  const auto file = std::filesystem::path(argv[2]) / ("made." + std::string(argv[1]));
  std::ofstream(file, std::ios::binary) << encoded->bytes;
}
