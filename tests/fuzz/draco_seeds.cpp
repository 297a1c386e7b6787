// Writes small Draco files into a folder, for the fuzzer to start from: binary seeds are made, not committed.
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

/// The mesh above, unmoved, as Draco.
std::string as_draco(const DracoOptions& options) {
  const RunControl run;
  const auto document = decode(kMesh, Format::Obj, {}, run);
  const auto surface = prepare_surface((*document)->positions(), (*document)->triangles(), run);
  const std::vector<Vec3f>& same = surface->mesh.positions;
  const MovedPositions moved{(*document)->positions(), surface->weld, same, same, surface->mesh.frame};
  return encode(**document, moved, {.format = Format::Draco, .draco = options}, run)->bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: draco_seeds FOLDER\n", stderr);
    return 2;
  }
  int number = 0;
  for (const DracoMethod method : {DracoMethod::Sequential, DracoMethod::Edgebreaker}) {
    for (const int bits : {0, 8}) {
      for (const int speed : {0, 5, 10}) {
        const std::filesystem::path file =
            std::filesystem::path(argv[1]) / ("made-" + std::to_string(++number) + ".drc");
        std::ofstream(file, std::ios::binary) << as_draco({.method = method,
                                                           .position_bits = bits,
                                                           .normal_bits = bits,
                                                           .texture_coordinate_bits = bits,
                                                           .speed = speed});
      }
    }
  }
}
