// Writes small GLB files into a folder, for the fuzzer to start from: binary seeds are made, not committed.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/io/draco.h"
#include "tests/support/glb.h"

namespace {

using namespace burnish;
using namespace burnish::testing;
using Json = nlohmann::ordered_json;

/// Four corners, folded along the middle.
const std::vector<Vec3f> kPoints = {{0, 0, 0},    {1, 0, 0},       {0, 1, 0},
                                    {1, 1, 0.5f}, {0.5f, 0.5f, 1}, {0, 0, 1}};

TestGlb list() {
  TestGlb glb;
  const std::vector<Vec3f> up(kPoints.size(), {0, 0, 1});
  const int position = glb.positions(kPoints), normal = glb.vectors(up);
  glb.mesh(
      Json::array(
          {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", 3}, {"COLOR_0", 4}}},
            {"indices", glb.indices(std::vector<std::uint8_t>{0, 1, 2, 1, 3, 2, 1, 4, 3, 0, 5, 1})},
            {"targets", {{{"POSITION", normal}}}}}}),
      "a");
  glb.accessor(glb.view(std::string(8 * kPoints.size(), '\x3e')), 0, kPoints.size(), kGlbFloat, "VEC2");
  glb.accessor(glb.view(std::string(4 * kPoints.size(), '\x7f')), 0, kPoints.size(), kGlbUInt8, "VEC4");
  glb.json["accessors"][4]["normalized"] = true;
  glb.json["nodes"] = {{{"mesh", 0}, {"name", "b"}}};
  return glb;
}

TestGlb strip_and_fan() {
  TestGlb glb;
  std::string rows;
  for (const Vec3f& p : kPoints) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = static_cast<std::int16_t>(p[axis] * 1000);
      rows.append(reinterpret_cast<const char*>(&value), 2);
    }
    rows.append("##");
  }
  const int position = glb.accessor(glb.view(rows, 8), 0, kPoints.size(), kGlbInt16, "VEC3");
  glb.mesh(Json::array({{{"attributes", {{"POSITION", position}}}, {"mode", 5}},
                        {{"attributes", {{"POSITION", position}}}, {"mode", 1}}}));
  glb.mesh(Json::array({{{"attributes", {{"POSITION", position}}}, {"mode", 6}}}));
  return glb;
}

TestGlb data_uri() {
  TestGlb glb;
  glb.mesh(Json::array({{{"attributes", {{"POSITION", 0}}}}}));
  glb.json["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}};
  glb.json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 36}}};
  glb.json["buffers"] = {
      {{"uri", "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}, {"byteLength", 36}}};
  return glb;
}

TestGlb compressed(DracoMethod method, int bits) {
  const RunControl run;
  std::vector<Vec3d> positions;
  for (const Vec3f& p : kPoints) positions.push_back(to_double(p));
  const std::vector<Triangle> triangles = {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}, {0, 5, 1}};
  const auto surface = prepare_surface(positions, triangles, run);
  const std::vector<Vec3f>& same = surface->mesh.positions;
  const MovedPositions moved{positions, surface->weld, same, same, surface->mesh.frame};
  const auto drc = encode_as_draco(moved, triangles, {}, {.method = method, .position_bits = bits}, run);
  TestGlb glb;
  const int view = glb.view(drc->bytes);
  glb.view("behind");
  glb.json["accessors"] = {
      {{"componentType", 5126}, {"count", 6}, {"type", "VEC3"}, {"min", {0, 0, 0}}, {"max", {1, 1, 1}}},
      {{"componentType", 5121}, {"count", 12}, {"type", "SCALAR"}}};
  glb.mesh(Json::array(
      {{{"attributes", {{"POSITION", 0}}},
        {"indices", 1},
        {"extensions",
         {{"KHR_draco_mesh_compression", {{"bufferView", view}, {"attributes", {{"POSITION", 0}}}}}}}}}));
  return glb;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: glb_seeds FOLDER\n", stderr);
    return 2;
  }
  const TestGlb files[] = {list(),
                           strip_and_fan(),
                           data_uri(),
                           compressed(DracoMethod::Sequential, 0),
                           compressed(DracoMethod::Sequential, 8),
                           compressed(DracoMethod::Edgebreaker, 8)};
  int number = 0;
  for (const TestGlb& glb : files) {
    const std::string bytes = glb.bytes();
    const GlbChunks chunks = split_glb(bytes);
    const std::filesystem::path folder = argv[1];
    const std::string name = "made-" + std::to_string(++number);
    std::ofstream(folder / (name + ".glb"), std::ios::binary) << bytes;
    std::ofstream(folder / (name + ".parts"), std::ios::binary) << chunks.json << '\0' << chunks.bin;
  }
}
