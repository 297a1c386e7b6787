#include <gmock/gmock.h>

#include <set>

#include "client/render/color_map.h"
#include "tests/client/cli_fixture.h"
#include "tests/client/png.h"

namespace burnish::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST_F(CommandLine, DrawsMeshesSideBySide) {
  const std::string png = folder / "a.png";
  const Outcome done =
      burnish({"render", noisy, clean, png, "--size", "200x120", "--background", "#102030", "--json"});
  ASSERT_EQ(done.code, 0) << done.err;
  const auto json = json_of(done.out);
  EXPECT_EQ(json["width"], 200);
  EXPECT_EQ(json["bytes"], folder.read("a.png").size());
  const render::Picture picture = render::from_png(folder.read("a.png"));
  EXPECT_EQ(picture.height, 120u);
  EXPECT_EQ(picture.at(0, 0), (render::Color{0x10, 0x20, 0x30}));
  for (const unsigned x : {50U, 150U}) EXPECT_NE(picture.at(x, 50), picture.at(0, 0)) << x;
  ASSERT_EQ(burnish({"render", noisy, clean, folder / "b.png", "--size", "200x120", "--background", "#102030",
                     "--threads", "1"})
                .code,
            0);
  EXPECT_EQ(folder.read("a.png"), folder.read("b.png"));
}

TEST_F(CommandLine, DrawsToStandardOutputFromStandardInput) {
  const Outcome done = burnish_with_input(folder.read("clean.obj"), {"render", "-", "-", "--size", "64x64"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(render::from_png(done.out).width, 64u);
}

TEST_F(CommandLine, DrawsTheDistanceToAReference) {
  const auto heat_most = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"render", noisy, folder / "h.png", "--size", "160x160", "--occlusion", "0",
                               "--samples", "2", "--reference", clean, "--json"});
    const Outcome done = burnish(more);
    EXPECT_EQ(done.code, 0) << done.err;
    return json_of(done.out)["heatMost"].get<double>();
  };
  const double largest =
      json_of(burnish({"compare", clean, noisy, "--json"}).out)["errors"]["maxDistance"].get<double>();
  EXPECT_GT(heat_most({}), largest / 10);
  EXPECT_LT(heat_most({}), largest * 5);
  EXPECT_EQ(heat_most({"--heat-most", "0.125"}), 0.125);
  const auto json = json_of(burnish({"render", noisy, folder / "h.png", "--size", "160x160", "--occlusion",
                                     "0", "--samples", "2", "--reference", clean, "--json"})
                                .out);
  EXPECT_NEAR(json["heatLargest"].get<double>(), largest, 1e-9);
  // The legend says that there is more where there is.
  const auto drawn = [&](const std::string& most) {
    EXPECT_EQ(burnish({"render", clean, folder / "o.png", "--size", "300x160", "--occlusion", "0",
                       "--samples", "2", "--reference", noisy, "--heat-most", most})
                  .code,
              0);
    return render::from_png(folder.read("o.png"));
  };
  const auto ink = [&](const render::Picture& picture) {
    std::size_t count = 0;
    for (unsigned y = 110; y < 160; ++y) {
      for (unsigned x = 220; x < 300; ++x) count += picture.at(x, y)[0] < 200 ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(ink(drawn("0.2")), ink(drawn("90")) + 30);
  // A mesh on its reference is pale all over, and the legend has the dark colours.
  ASSERT_EQ(burnish({"render", clean, folder / "c.png", "--size", "160x200", "--occlusion", "0", "--samples",
                     "2", "--reference", clean, "--no-labels"})
                .code,
            0);
  const render::Picture pale = render::from_png(folder.read("c.png"));
  for (unsigned y = 0; y < 130; ++y) {
    for (unsigned x = 0; x < 160; ++x) EXPECT_LT(pale.at(x, y)[0] - pale.at(x, y)[2], 25) << x << " " << y;
  }
  const std::set<render::Color> seen(pale.pixels.begin(), pale.pixels.end());
  EXPECT_TRUE(seen.contains(render::heat_color(63.5 / 64)));
}

TEST_F(CommandLine, DrawsTheColoursOfTheVertices) {
  const std::string red = folder.write("red.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n");
  ASSERT_EQ(
      burnish({"render", red, folder / "r.png", "--size", "64x64", "--vertex-colors", "--azimuth", "0"}).code,
      0);
  const render::Picture picture = render::from_png(folder.read("r.png"));
  const render::Color color = picture.at(25, 40);
  EXPECT_GT(color[0], 100);
  EXPECT_LT(color[1], 100);
}

TEST_F(CommandLine, NamesWhatCannotBeDrawn) {
  const std::string png = folder / "x.png";
  const std::string bad = folder.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  struct Row {
    std::vector<std::string> arguments;
    int code;
    std::string start;
  };
  const Row rows[] = {
      {{"render", noisy}, 2, "burnish: bad_option: "},
      {{"render", noisy, png, "--size", "64"}, 2, "burnish: bad_option: --size takes WIDTHxHEIGHT"},
      {{"render", noisy, png, "--size", "8x64"}, 2, "burnish: bad_option: --size takes WIDTHxHEIGHT"},
      {{"render", noisy, png, "--size", "64x64x"}, 2, "burnish: bad_option: --size takes WIDTHxHEIGHT"},
      {{"render", noisy, png, "--background", "white"}, 2, "burnish: bad_option: 'white' is no colour"},
      {{"render", noisy, png, "--label", "a", "--label", "b"},
       2,
       "burnish: bad_option: --label is given 2 times for 1 mesh"},
      {{"render", noisy, png, "--elevation", "91"}, 2, "burnish: bad_option: "},
      {{"render", noisy, png, "--up", "x"}, 2, "burnish: bad_option: "},
      {{"render", noisy, png, "--heat-most", "1"}, 2, "burnish: bad_option: "},
      {{"render", noisy, png, "--vertex-colors"}, 2, "burnish: bad_option: " + noisy + " has no colours"},
      {{"render", bad, png}, 3, "burnish: index_out_of_range: " + bad + ": "},
      {{"render", noisy, png, "--reference", bad}, 3, "burnish: index_out_of_range: " + bad + ": "},
      {{"render", folder / "none.obj", png}, 6, "burnish: file_error: "},
      {{"render", noisy, folder / "no/where.png"}, 6, "burnish: file_error: "},
  };
  for (const Row& row : rows) {
    const Outcome done = burnish(row.arguments);
    const std::string call = ::testing::PrintToString(row.arguments);
    EXPECT_EQ(done.code, row.code) << call << done.err;
    EXPECT_THAT(done.err, StartsWith(row.start)) << call;
    EXPECT_EQ(done.out, "") << call;
    EXPECT_FALSE(std::filesystem::exists(png)) << call;
  }
}

}  // namespace
}  // namespace burnish::cli
