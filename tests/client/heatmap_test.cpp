#include <gmock/gmock.h>

#include <cmath>

#include "client/cli/heat.h"
#include "client/cli/mesh_files.h"
#include "client/render/color_map.h"
#include "tests/client/cli_fixture.h"

namespace burnish::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

LoadedMesh loaded(const std::string& bytes) {
  v1::StageTimings timings;
  auto mesh = load_mesh(bytes, std::nullopt, "", no_limits(), {}, timings);
  EXPECT_TRUE(mesh);
  return std::move(*mesh);
}

std::vector<float> colors_of(const std::string& bytes) {
  const LoadedMesh mesh = loaded(bytes);
  const Surface& surface = mesh.surface;
  const MovedPositions still{mesh.document->positions(), surface.weld, surface.mesh.positions,
                             surface.mesh.positions, surface.mesh.frame};
  return mesh.document->shared_attributes(still, {})->colors;
}

/// Colours are bytes in the PLY and six digits in the OBJ.
void expect_colors_of_distances(const std::vector<float>& colors, const std::vector<double>& distances,
                                double most) {
  ASSERT_EQ(colors.size(), 3 * distances.size());
  for (std::size_t v = 0; v < distances.size(); ++v) {
    const render::Color expected = render::heat_color(distances[v] / most);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(std::lround(255 * colors[3 * v + c]), expected[c]) << v;
  }
}

TEST_F(CommandLine, ColoursEveryVertexByItsDistance) {
  const std::string truth = folder.read("clean.obj"), bytes = folder.read("noisy.obj");
  const auto distances = file_vertex_distances(loaded(bytes), loaded(truth), {});
  ASSERT_TRUE(distances);
  for (const char* const name : {"heat.ply", "heat.obj"}) {
    const Outcome done = burnish({"compare", clean, noisy, "--heatmap", folder / name, "--json"});
    ASSERT_EQ(done.code, 0) << done.err;
    const auto json = json_of(done.out);
    EXPECT_EQ(json["heatmap"]["largest"].get<double>(),
              *std::max_element(distances->begin(), distances->end()));
    EXPECT_NEAR(json["errors"]["maxDistance"].get<double>(), json["heatmap"]["largest"].get<double>(), 1e-9);
    expect_colors_of_distances(colors_of(folder.read(name)), *distances,
                               json["heatmap"]["most"].get<double>());
  }
  EXPECT_THAT(folder.read("heat.ply"), StartsWith("ply\nformat binary_little_endian 1.0\n"));
}

TEST_F(CommandLine, ColoursOnAScaleOfOnesOwn) {
  const Outcome done = burnish({"compare", clean, noisy, "--heatmap", folder / "h", "--heat-most", "0.5"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("darkest             0.5 or more, up to "));
  EXPECT_THAT(folder.read("h"), StartsWith("ply\n")) << "a name without a format";
  const auto distances =
      file_vertex_distances(loaded(folder.read("noisy.obj")), loaded(folder.read("clean.obj")), {});
  expect_colors_of_distances(colors_of(folder.read("h")), *distances, 0.5);
}

TEST_F(CommandLine, RefusesHeatMapsThatCannotBe) {
  EXPECT_EQ(burnish({"compare", clean, noisy, "--heatmap", folder / "no/where.ply"}).code, 6);
  const Outcome stl = burnish({"compare", clean, noisy, "--heatmap", folder / "h.stl"});
  EXPECT_EQ(stl.code, 2);
  EXPECT_THAT(stl.err, HasSubstr("has no colours"));
  EXPECT_EQ(burnish({"compare", clean, noisy, "--heat-most", "1"}).code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "h.stl"));
}

TEST(EndOfHeat, IsRoundAndNotMovedByTheFarthestFew) {
  std::vector<double> values(1000, 0.4);
  values[7] = 90;
  EXPECT_EQ(end_of_heat(values), 0.5);
  EXPECT_EQ(end_of_heat({}), 1);
  EXPECT_EQ(end_of_heat({0, 0, 0}), 1);
  EXPECT_EQ(end_of_heat({3}), 5);
}

}  // namespace
}  // namespace burnish::cli
