#include "core/io/obj.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/shapes.h"

namespace burnish {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace burnish::testing;

constexpr const char* kScan =
    "# a scan: C:\\dir\\\r\n"
    "mtllib scan.mtl\r\n"
    "o thing\n"
    "v 0 0 0 1 0.5 0\n"
    "v  1.000 0 0   0 0 1 # red\n"
    "v\t1 1 0.25 0 1 0\n"
    "v 0 1 0 0 0 0\n"
    "v 0.5 0.5 \\\n   1 1 1 1\n"
    "\n"
    "vt 0 0\nvt 1 0\nvt 1 1\n"
    "vn 0 0 1\n"
    "vn 1 0 0  # cited by nobody\n"
    "g side\n"
    "usemtl red\n"
    "s off\n"
    "f 1/1/1 2/2/1 3/3/1 4//1\n"
    "f 1 2 5\n"
    "f -3 -2 \\\n -1\n"
    "l 1 2 3\n"
    "p 1";

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

struct Loaded {
  std::unique_ptr<Document> document;
  Surface surface;

  explicit Loaded(std::string_view text) {
    auto decoded = decode(text, std::nullopt, {}, {});
    if (!decoded) {
      ADD_FAILURE() << decoded.error().message;
      std::abort();
    }
    document = std::move(*decoded);
    surface = std::move(*prepare_surface(document->positions(), document->triangles(), {}));
  }

  std::string write(std::span<const Vec3f> after, const OutputOptions& options = {}) const {
    const MovedPositions moved{document->positions(), surface.weld, surface.mesh.positions, after,
                               surface.mesh.frame};
    return encode(*document, moved, options, {})->bytes;
  }
};

Error error_of(std::string_view text, const Limits& limits = {}) {
  const auto result = decode(text, Format::Obj, limits, {});
  return result ? Error{Cause::Internal, "accepted"} : result.error();
}

TEST(Obj, ReadsVerticesFacesAndPolygons) {
  const Loaded loaded(kScan);
  EXPECT_EQ(loaded.document->positions().size(), 5U);
  EXPECT_EQ(loaded.document->positions()[4], (Vec3d{0.5, 0.5, 1}));
  EXPECT_THAT(loaded.document->triangles(),
              ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{0, 1, 4}, Triangle{2, 3, 4}));
}

TEST(Obj, ComesBackByteForByteWhenNothingMoved) {
  const Loaded loaded(kScan);
  EXPECT_EQ(loaded.write(loaded.surface.mesh.positions), kScan);
}

TEST(Obj, ChangesOnlyMovedVerticesAndTheirNormals) {
  const Loaded loaded(kScan);
  auto after = loaded.surface.mesh.positions;
  after[loaded.surface.weld[1]].z += 0.25F;
  const auto was = lines(kScan), is = lines(loaded.write(after));
  ASSERT_EQ(was.size(), is.size());
  for (std::size_t i = 0; i < was.size(); ++i) {
    const bool changes = was[i].starts_with("v  1.000") || was[i] == "vn 0 0 1";
    EXPECT_EQ(was[i] != is[i], changes) << was[i];
  }
  EXPECT_EQ(is[4], "v  1.00000000 0.00000000 0.25000000   0 0 1 # red");
}

TEST(Obj, RecomputesNormalsAsAngleWeightedSums) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
  const Loaded loaded(text);
  auto after = loaded.surface.mesh.positions;
  after[1].z += after[1].x - after[0].x;  // the triangle now leans by 45 degrees
  EXPECT_EQ(lines(loaded.write(after))[3], "vn -0.707107 0.000000 0.707107");
}

// Found by the fuzzer: the recomputed normal was written right behind the keyword, "vn-0.70...", which no
// reader takes for a normal.
TEST(Obj, LeavesANormalWithoutNumbersAsItIs) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn\nvn # none\nvn 1\nf 1//1 2//2 3//3\n";
  const Loaded loaded(text);
  auto after = loaded.surface.mesh.positions;
  after[1].z += after[1].x - after[0].x;
  const auto is = lines(loaded.write(after));
  EXPECT_THAT(std::vector(is.begin() + 3, is.begin() + 6),
              ElementsAre("vn", "vn # none", "vn -0.707107 0.000000 0.707107"));
}

TEST(Obj, KeepsTheDigitsOfCoordinatesFarFromTheOrigin) {
  const std::string text = "v 5000000.125 0 0\nv 5000001.125 0 0\nv 5000000.125 1 0\nf 1 2 3\n";
  const Loaded loaded(text);
  auto after = loaded.surface.mesh.positions;
  after[1].y += 0x1p-10F;
  const auto is = lines(loaded.write(after));
  EXPECT_EQ(is[0], "v 5000000.125 0 0");
  EXPECT_EQ(is[1], "v 5000001.12500000 0.00097656 0.00000000");
}

TEST(Obj, FindsAFileThatItWroteItselfUnchanged) {
  const Shape shape = with_noise(sphere(2), 0.05);
  const std::string text = to_obj(shape);
  const Loaded first(text);
  auto after = first.surface.mesh.positions;
  for (Vec3f& p : after) p *= 0.9F;
  const std::string written = first.write(after);
  const Loaded second(written);
  EXPECT_EQ(second.write(second.surface.mesh.positions), written);
}

TEST(Obj, MovesWeldedVerticesAsOne) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 4 6 5\n";
  const Loaded loaded(text);
  auto after = loaded.surface.mesh.positions;
  after[loaded.surface.weld[1]].z += 0.5F;
  const auto is = lines(loaded.write(after));
  EXPECT_EQ(is[1], is[3]);
  EXPECT_NE(is[1], "v 1 0 0");
  EXPECT_EQ(is[2], "v 0 1 0");
}

TEST(Obj, NamesThePlaceOfEachMistake) {
  struct Row {
    const char* text;
    Cause cause;
    const char* says;
  };
  const std::string head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const Row rows[] = {
      {"v 0 0\n", Cause::MalformedMesh,
       "vertex 1: coordinate z is not a number but the end of the line (line 1)"},
      {"v 0 zero 0\n", Cause::MalformedMesh, "vertex 1: coordinate y is not a number but \"zero\" (line 1)"},
      {"v 0 1,5 0\n", Cause::MalformedMesh, "coordinate y is not a number but \"1,5\""},
      {"\r\n\r\nv nan 0 0\n", Cause::NonFinitePosition,
       "vertex 1: coordinate x is \"nan\", not a finite number (line 3)"},
      {"v 0 0 1e999\n", Cause::NonFinitePosition, "coordinate z"},
      {"v 0 0 -1e61\n", Cause::NonFinitePosition, "beyond 1e60"},
      {"@f 1 2 9\n", Cause::IndexOutOfRange, "face 1 uses vertex 9 of 3 (line 4)"},
      {"@f 1 2 3\nf 1 0 3\n", Cause::IndexOutOfRange, "face 2 uses vertex 0; OBJ counts from 1 (line 5)"},
      {"@f 1 -4 3\n", Cause::IndexOutOfRange, "face 1 uses vertex -4 of 3 (line 4)"},
      {"@f 1 2 1000000000\n", Cause::IndexOutOfRange, "vertex 1000000000 of 3"},
      {"@f 1 2 99999999999999999999\n", Cause::IndexOutOfRange, "99999999999999999999"},
      {"@f 1/1 2/1 3/1\n", Cause::IndexOutOfRange, "texture coordinate 1 of 0"},
      {"@f 1//1 2//1 3//1\n", Cause::IndexOutOfRange, "normal 1 of 0"},
      {"@f 1 2\n", Cause::MalformedMesh, "face 1 has 2 corners; it needs at least 3 (line 4)"},
      {"@f\n", Cause::MalformedMesh, "face 1 has 0 corners"},
      {"@f 1 two 3\n", Cause::MalformedMesh, "face 1: a vertex index is not a number but \"two\" (line 4)"},
      {"@f 1/2/3/4 2 3\n", Cause::MalformedMesh, "face 1"},
      {"@f 1.5 2 3\n", Cause::MalformedMesh, "unexpected \".5\" in a corner"},
      {"@", Cause::EmptyMesh, "no face"},
      {"f 1 2 3\n", Cause::IndexOutOfRange, "vertex 3 of 0"},
      {"", Cause::EmptyMesh, "no vertex"},
      {"hello\n", Cause::EmptyMesh, "no vertex"},
  };
  for (const Row& row : rows) {
    const std::string text = row.text[0] == '@' ? head + (row.text + 1) : row.text;
    const Error error = error_of(text);
    EXPECT_EQ(cause_code(error.cause), cause_code(row.cause)) << text << error.message;
    EXPECT_THAT(error.message, HasSubstr(row.says)) << text;
  }
}

TEST(Obj, CountsContinuedFacesAsItReadThem) {
  // A line that begins behind a backslash is no face of its own, whatever it looks like; a keyword may begin
  // there too.
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 \\\nf 1\nf 1 \\\n2 3\n\\\r\nf 1 2 4\nf 2 3 4\n";
  const auto document = decode(text, Format::Obj, {}, {});
  ASSERT_TRUE(document) << document.error().message;
  ASSERT_EQ((*document)->triangles().size(), 3U);
  EXPECT_EQ((*document)->triangle_place(0), "face 1 (line 7)");
  EXPECT_EQ((*document)->triangle_place(1), "face 2 (line 10)");
  EXPECT_EQ((*document)->triangle_place(2), "face 3 (line 11)");
}

TEST(Obj, AcceptsWhatScannersWrite) {
  const std::string head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const std::string& text : std::initializer_list<std::string>{
           "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n",          // faces before their vertices
           head + "f 1 2 3 # comment",                      // comment, no line end
           head + "f  1\t2 3 \t\r\n",                       // odd blanks
           "v +0 0 0\rv 1e0 .0 0.\rv 0 1 0\rf 1 2 3",       // old Macintosh line ends
           head + "f 1/ 2/ 3/\n",                           // empty texture references
           head + "vt 0\nvn 0 0 0\nf 1/1/1 2/1/1 3/1/1\n",  // one texture coordinate
           std::string("\xef\xbb\xbf# BOM\n") + head + "f 1 2 3\n",
       }) {
    EXPECT_TRUE(decode(text, std::nullopt, {}, {})) << text << error_of(text).message;
  }
}

TEST(Obj, HoldsItsLimitsAndNamesThem) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n";
  struct Row {
    Limits limits;
    const char* says;
  };
  const Row rows[] = {
      {{.max_vertices = 3}, "more than 3 vertices (max-vertices) (line 4)"},
      {{.max_triangles = 1}, "more than 1 triangles (max-triangles) (line 5)"},
      {{.max_bytes = 10}, "the limit is 10 (max-bytes)"},
      {{.max_line_bytes = 8}, "a line has more than 8 bytes (max-line-bytes) (line 5)"},
  };
  for (const Row& row : rows) {
    const Error error = error_of(text, row.limits);
    EXPECT_EQ(error.cause, Cause::TooLarge) << row.says;
    EXPECT_THAT(error.message, HasSubstr(row.says));
  }
  EXPECT_EQ(error_of(text, {.max_line_bytes = 9}).message, "accepted");
}

TEST(Obj, RefusesALineOverItsLimitWhateverItHolds) {
  const std::string head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", tail = "\nf 1 2 3\n";
  const auto many = [](const std::string& part) {
    std::string text;
    while (text.size() < 200) text += part;
    return text;
  };
  for (const std::string& line :
       {"# " + many("comment"), many("g"), "v " + many("0"), "v 0 0 0 " + many("1 "), "vt" + many(" 0"),
        "vn " + many("0"), "f" + many(" 1/1"), "f 1 2 " + many("3"), many(" "), many("\\\n"),
        "v 0 \\\r\n" + many(" \\\n") + "0 0", many("f")}) {
    const Error refused = error_of(head + line + tail, {.max_line_bytes = 100});
    EXPECT_EQ(refused.cause, Cause::TooLarge) << line;
    EXPECT_THAT(refused.message, HasSubstr("(max-line-bytes) (line 4)")) << line;
  }
  // At the end of the file, with and without a line end.
  for (const char* end : {"", "\n", "\r\n", "\r"}) {
    EXPECT_EQ(error_of("f 1 2 3\n" + head + "# 345678901" + end, {.max_line_bytes = 10}).cause,
              Cause::TooLarge);
    EXPECT_EQ(error_of("f 1 2 3\n" + head + "# 34567890" + end, {.max_line_bytes = 10}).message, "accepted");
  }
}

TEST(Obj, NoticesItsDeadlineAmongLongLines) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (int line = 0; line < 64; ++line) text += '#' + std::string(1 << 19, ' ') + '\n';
  const auto soon = RunControl::Clock::now() + std::chrono::microseconds(100);
  const auto result = decode(text, Format::Obj, {}, {.deadline = soon});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().cause, Cause::DeadlineExceeded);
}

TEST(Obj, MeetsEveryTruncationWithAnAnswer) {
  const std::string whole = kScan;
  std::size_t accepted = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::string prefix = whole.substr(0, length);  // a copy: a sanitizer sees any step past its end
    const auto result = decode(prefix, Format::Obj, {}, {});
    if (result) {
      ++accepted;
    } else {
      EXPECT_NE(result.error().message, "");
    }
  }
  EXPECT_GT(accepted, 0U);
  EXPECT_LT(accepted, whole.size());
}

TEST(Obj, SurvivesEveryOneByteMutation) {
  const std::string whole = kScan;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const char c : {'\0', '\n', '\\', '/', '-', '9', 'v', 'f', ' ', '\xff'}) {
      std::string mutant = whole;
      mutant[at] = c;
      auto decoded = decode(mutant, Format::Obj, {}, {});
      if (!decoded) continue;
      const auto surface = prepare_surface((*decoded)->positions(), (*decoded)->triangles(), {});
      ASSERT_TRUE(surface);
      const auto& same = surface->mesh.positions;
      const MovedPositions moved{(*decoded)->positions(), surface->weld, same, same, surface->mesh.frame};
      const auto written = encode(**decoded, moved, {}, {});
      ASSERT_TRUE(written);
      EXPECT_EQ(written->bytes, mutant);
    }
  }
}

TEST(Obj, BecomesDracoAndComesBackWithColoursNormalsAndTextures) {
  const Loaded loaded(kScan);
  const std::string draco = loaded.write(loaded.surface.mesh.positions, {.format = Format::Draco});
  const Loaded back(draco);
  EXPECT_EQ(back.document->format(), Format::Draco);
  EXPECT_EQ(back.document->triangles().size(), 4U);
  const std::string obj = back.write(back.surface.mesh.positions, {.format = Format::Obj});
  EXPECT_THAT(obj, HasSubstr("v 0.00000000 0.00000000 0.00000000 1.000000 0.500000 0.000000\n"));
  EXPECT_THAT(obj, HasSubstr("vt 1.00000000 1.00000000"));
  EXPECT_THAT(obj, HasSubstr("vn 0.000000 0.000000 1.000000"));
}

TEST(DetectFormat, TellsByContent) {
  EXPECT_EQ(detect_format("DRACO\2\2"), Format::Draco);
  EXPECT_EQ(detect_format("v 0 0 0"), Format::Obj);
  EXPECT_EQ(detect_format(std::string_view("GIF8\2\0\0\0", 8)), std::nullopt);
  EXPECT_EQ(decode(std::string_view("\1\2\3"), std::nullopt, {}, {}).error().cause, Cause::UnsupportedFormat);
}

}  // namespace
}  // namespace burnish
