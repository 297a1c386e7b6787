#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "client/render/color_map.h"
#include "client/render/ray_caster.h"
#include "client/render/sheet.h"
#include "client/render/text.h"
#include "core/run/math.h"
#include "tests/client/png.h"
#include "tests/support/shapes.h"

namespace burnish::render {
namespace {

using testing::cube;
using testing::Shape;
using testing::sphere;

constexpr Color kBackground = {244, 245, 247};

Panel panel(const Shape& shape, View view = {}) {
  return {.model = {.positions = shape.positions, .triangles = shape.triangles}, .label = {}, .view = view};
}

Sheet sheet(unsigned width, unsigned height) {
  Sheet sheet{.width = width, .height = height};
  sheet.look.background = kBackground;
  return sheet;
}

Picture drawn(const std::vector<Panel>& panels, const Sheet& how, unsigned threads = 2) {
  auto picture = draw_sheet(panels, how, {.threads = threads});
  EXPECT_TRUE(picture) << picture.error().message;
  return std::move(*picture);
}

double brightness(const Color& color) { return (color[0] + color[1] + color[2]) / 3.0; }

/// Pixels that are not background.
std::size_t covered(const Picture& picture) {
  return static_cast<std::size_t>(std::count_if(picture.pixels.begin(), picture.pixels.end(),
                                                [](const Color& color) { return color != kBackground; }));
}

TEST(DrawSheet, ShowsASphereAsADiscInTheMiddle) {
  const Shape ball = sphere(5);
  Sheet how = sheet(200, 120);
  how.margin = 0.1;
  how.look.samples = 1;  // a pixel is either in or out
  const Picture picture = drawn({panel(ball)}, how);
  EXPECT_EQ(picture.at(0, 0), kBackground);
  EXPECT_EQ(picture.at(199, 119), kBackground);
  EXPECT_GT(brightness(picture.at(100, 60)), 100);
  const double radius = 120 * (1 - 2 * how.margin) / 2;
  EXPECT_NEAR(static_cast<double>(covered(picture)), kPi * radius * radius, 0.01 * kPi * radius * radius);
  EXPECT_EQ(picture.at(100 - static_cast<unsigned>(radius) - 2, 60), kBackground);
  EXPECT_NE(picture.at(100 - static_cast<unsigned>(radius) + 1, 60), kBackground);
}

TEST(DrawSheet, GivesTheSameBytesForAnyNumberOfThreads) {
  const Shape shape = testing::with_noise(cube(12), 0.02);
  const auto one = to_png(drawn({panel(shape), panel(sphere(3))}, sheet(160, 80), 1));
  const auto two = to_png(drawn({panel(shape), panel(sphere(3))}, sheet(160, 80), 2));
  ASSERT_TRUE(one && two);
  EXPECT_EQ(*one, *two);
}

TEST(DrawSheet, IsLitFromTheUpperLeft) {
  const Shape ball = sphere(4);
  const Picture picture = drawn({panel(ball)}, sheet(100, 100));
  EXPECT_GT(brightness(picture.at(35, 35)), brightness(picture.at(65, 65)) + 20);
}

TEST(DrawSheet, SmoothsEdgesOfTheSilhouette) {
  const Shape ball = sphere(4);
  Sheet how = sheet(60, 60);
  how.look.paint = {0, 0, 0};
  const auto shades = [&](unsigned samples) {
    how.look.samples = samples;
    std::set<Color> colors;
    const Picture picture = drawn({panel(ball)}, how);
    for (unsigned x = 0; x < 60; ++x) colors.insert(picture.at(x, 3));  // across the rim
    return colors.size();
  };
  EXPECT_GT(shades(4), shades(1));
}

TEST(DrawSheet, SeesTheSideThatTheViewNames) {
  const Shape box = cube(1);
  // Heat marks the vertices with x = 1: the side seen from 90 degrees to the right, whichever axis is up.
  std::vector<float> heat;
  for (const Vec3d& p : box.positions) heat.push_back(p.x > 0 ? 1 : 0);
  for (const UpAxis up : {UpAxis::Y, UpAxis::Z}) {
    const auto centre = [&](double azimuth, double elevation) {
      Panel seen = panel(box, {.azimuth = azimuth, .elevation = elevation, .up = up});
      seen.model.heat = heat;
      const Picture picture = drawn({seen}, sheet(32, 32));
      return brightness(picture.at(16, 16));
    };
    EXPECT_LT(centre(90, 0) + 40, centre(-90, 0));
  }
}

TEST(DrawSheet, ShadesFlatTrianglesEvenlyAndSmoothOnesNot) {
  const Shape ball = sphere(1);
  Sheet how = sheet(200, 200);
  how.look.occlusion = 0;
  const auto shades = [&](Shading shading) {
    how.look.shading = shading;
    std::set<Color> colors;
    const Picture picture = drawn({panel(ball)}, how);
    for (unsigned y = 80; y < 120; ++y) {
      for (unsigned x = 80; x < 120; ++x) colors.insert(picture.at(x, y));
    }
    return colors.size();
  };
  EXPECT_LT(shades(Shading::Flat) * 3, shades(Shading::Smooth));
}

TEST(DrawSheet, DarkensWhereTheSurfaceHidesTheSky) {
  // The floor of a trench, from above.
  constexpr double kHalf = 0.3, kDeep = 3;
  const Shape trench{.positions = {{-kHalf, 0, -1},
                                   {kHalf, 0, -1},
                                   {kHalf, 0, 1},
                                   {-kHalf, 0, 1},
                                   {-kHalf, kDeep, -1},
                                   {-kHalf, kDeep, 1},
                                   {kHalf, kDeep, -1},
                                   {kHalf, kDeep, 1}},
                     .triangles = {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {3, 4, 5}, {1, 2, 6}, {2, 7, 6}}};
  Sheet how = sheet(64, 64);
  how.look.shading = Shading::Flat;
  const auto floor = [&](unsigned occlusion) {
    how.look.occlusion = occlusion;
    return brightness(drawn({panel(trench, {.azimuth = 0, .elevation = 90})}, how).at(32, 32));
  };
  EXPECT_LT(floor(8) + 10, floor(0));
}

TEST(DrawSheet, ComparesMeshesOfARowFromOnePlace) {
  const Shape large = sphere(3), small = testing::scaled(sphere(3), 0.5);
  Sheet how = sheet(200, 100);
  how.look.samples = 1;
  const auto halves = [&](Fit fit) {
    how.fit = fit;
    const Picture picture = drawn({panel(large), panel(small)}, how);
    std::pair<double, double> count;
    for (unsigned y = 0; y < 100; ++y) {
      for (unsigned x = 0; x < 200; ++x) {
        if (picture.at(x, y) != kBackground) ++(x < 100 ? count.first : count.second);
      }
    }
    return count.first / count.second;
  };
  EXPECT_NEAR(halves(Fit::Row), 4, 0.1);
  EXPECT_NEAR(halves(Fit::Each), 1, 0.02);
}

TEST(DrawSheet, PutsPanelsIntoRows) {
  const Shape ball = sphere(2);
  Sheet how = sheet(90, 60);
  how.columns = 3;
  const Picture picture = drawn({panel(ball), panel(ball), panel(ball), panel(ball)}, how);
  for (const auto& [x, y, filled] : {std::tuple{15U, 15U, true},
                                     {45U, 15U, true},
                                     {75U, 15U, true},
                                     {15U, 45U, true},
                                     {45U, 45U, false}}) {
    EXPECT_EQ(picture.at(x, y) != kBackground, filled) << x << " " << y;
  }
}

TEST(DrawSheet, DrawsTheLegendInTheColoursOfTheMap) {
  const Shape ball = sphere(2);
  std::vector<float> heat(ball.positions.size(), 0.5F);
  Panel hot = panel(ball);
  hot.model.heat = heat;
  Sheet how = sheet(500, 300);
  how.legend = Legend{.most = 2, .title = "distance in mm"};
  const Picture picture = drawn({hot}, how);
  std::set<Color> seen(picture.pixels.begin(), picture.pixels.end());
  const unsigned width = 500 * 2 / 5;
  for (unsigned x = 0; x < width; x += 7) EXPECT_TRUE(seen.contains(heat_color((x + 0.5) / width))) << x;
  // The mesh itself has the colour in the middle of the map, in light and shade: redder than blue by far.
  const Color centre = picture.at(250, 110);
  EXPECT_GT(centre[0], 2 * centre[2]);
}

TEST(DrawSheet, WritesLabelsBelowTheMeshes) {
  const Shape ball = sphere(2);
  Panel named = panel(ball);
  named.label = "noisy";
  const Picture picture = drawn({named}, sheet(120, 140));
  std::size_t ink = 0;
  for (unsigned y = 120; y < 140; ++y) {
    for (unsigned x = 0; x < 120; ++x) ink += picture.at(x, y) != kBackground ? 1 : 0;
  }
  EXPECT_GT(ink, 50u);
  EXPECT_LT(ink, 1000u);
}

TEST(DrawSheet, RefusesWhatHasNoRoomAndStopsWhenAsked) {
  const Shape ball = sphere(2);
  std::vector<Panel> many(100, panel(ball));
  const auto narrow = draw_sheet(many, sheet(200, 100), {});
  ASSERT_FALSE(narrow);
  EXPECT_EQ(narrow.error().cause, Cause::BadOption);
  EXPECT_FALSE(draw_sheet({}, sheet(200, 100), {}));
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = draw_sheet(std::vector{panel(ball)}, sheet(200, 100), {.stop = stop.get_token()});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().cause, Cause::Cancelled);
}

TEST(DrawSheet, DrawsMeshesFarAwayAndHugeAndFlat) {
  for (const Shape& shape : {testing::moved(sphere(3), {1e7, -1e7, 1e7}), testing::scaled(sphere(3), 1e40),
                             testing::scaled(sphere(3), 1e-30)}) {
    const Picture picture = drawn({panel(shape)}, sheet(60, 60));
    EXPECT_NE(picture.at(30, 30), kBackground);
    EXPECT_EQ(picture.at(1, 1), kBackground);
  }
  const Shape edge_on = testing::grid(3), point{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}};
  drawn({panel(edge_on, {.azimuth = 0, .elevation = 90})}, sheet(60, 60));
  drawn({panel(point)}, sheet(60, 60));
}

TEST(AxesOf, AreAtRightAngles) {
  for (const UpAxis up : {UpAxis::Y, UpAxis::Z}) {
    for (double azimuth = -360; azimuth <= 360; azimuth += 37) {
      for (const double elevation : {-90.0, -33.0, 0.0, 20.0, 90.0}) {
        const Axes axes = axes_of({.azimuth = azimuth, .elevation = elevation, .up = up});
        EXPECT_NEAR(dot(axes.right, axes.up), 0, 1e-12);
        EXPECT_NEAR(dot(axes.up, axes.eye), 0, 1e-12);
        EXPECT_NEAR(length(axes.up), 1, 1e-12);
        EXPECT_NEAR(dot(cross(axes.right, axes.up), axes.eye), 1, 1e-12);
        EXPECT_GE(up == UpAxis::Y ? axes.up.y : axes.up.z, -1e-12);
      }
    }
  }
}

TEST(HeatColor, DarkensThroughout) {
  double last = 256;
  for (int i = 0; i <= 100; ++i) {
    const Light light = to_light(heat_color(i / 100.0));
    const double luminance = 0.2126 * light.red + 0.7152 * light.green + 0.0722 * light.blue;
    EXPECT_LT(luminance, last) << i;
    last = luminance;
  }
  EXPECT_EQ(heat_color(-1), heat_color(0));
  EXPECT_EQ(heat_color(7), heat_color(1));
}

TEST(RoundUp, GivesEndsOfLegends) {
  for (const auto& [value, rounded] :
       {std::pair{0.0, 0.0}, {0.11, 0.2}, {1.0, 1.0}, {2.1, 2.5}, {2.6, 5.0}, {51.0, 100.0}}) {
    EXPECT_NEAR(round_up(value), rounded, 1e-12 * rounded) << value;
  }
}

TEST(Color, SurvivesItsLight) {
  for (int i = 0; i < 256; ++i) {
    const Color color = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i), 7};
    EXPECT_EQ(to_color(to_light(color)), color);
  }
  EXPECT_EQ(to_color({2, -1, 1}), (Color{255, 0, 255}));
}

TEST(Color, IsReadFromSixDigits) {
  ASSERT_TRUE(parse_color("#F4f5f7"));
  EXPECT_EQ(*parse_color("f4f5f7"), kBackground);
  for (const char* wrong : {"", "#", "#fff", "#f4f5f", "#f4f5f78", "#f4f5fg", "##f4f5f", "red"}) {
    EXPECT_FALSE(parse_color(wrong)) << wrong;
  }
}

TEST(ToPng, KeepsEveryPixel) {
  Picture picture(37, 11, kBackground);
  for (unsigned y = 0; y < 11; ++y) {
    for (unsigned x = 0; x < 37; ++x)
      picture.at(x, y) = {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(x * y), 9};
  }
  const auto bytes = to_png(picture);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(from_png(*bytes).pixels, picture.pixels);
}

TEST(Text, MeasuresAndSurvivesAnyBytes) {
  const auto text = Text::of_size(16);
  ASSERT_TRUE(text);
  EXPECT_EQ(text->width(""), 0u);
  EXPECT_GT(text->width("mm"), text->width("ii"));
  EXPECT_EQ(text->width("\xff\xc3"), text->width("??"));
  EXPECT_LT(text->width("\xc3\xa9"), text->width("??")) << "one letter";
  Picture picture(20, 20, kBackground);
  text->draw(picture, -5, 3, "\xe2\x82 \xf0\x9f mesh beyond every side", {0, 0, 0});
  EXPECT_NE(std::count(picture.pixels.begin(), picture.pixels.end(), kBackground), 400);
}

}  // namespace
}  // namespace burnish::render
