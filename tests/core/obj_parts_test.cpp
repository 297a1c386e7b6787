// Large OBJ files are read and written in parts by several threads: the outcome must be that of one.
#include <gtest/gtest.h>

#include <charconv>
#include <cstdlib>
#include <random>

#include "core/io/obj.h"
#include "core/io/plain_number.h"
#include "tests/support/shapes.h"

namespace burnish {
namespace {

using namespace burnish::testing;

const RunControl kOneThread{.threads = 1}, kTwoThreads{.threads = 2};

/// Every kind of line, some more than once, so that small parts begin and end at any of them.
std::string odd_text() {
  std::string text = "# C:\\dir\\\r\nmtllib scan.mtl\r\n";
  for (int i = 0; i < 12; ++i) {
    const std::string number = std::to_string(i);
    text += "v " + number + " 0.5 -1.25 0.1 0.2 0.3\n";
    text += "v  " + number + "e-1 +2 \\\n  3 # far\r\n";
    text += "v\t0." + number + "1234567890123456789\t-.5 7.\r\n";
    text += "vt 0." + number + " 1\nvn 0 0." + number + " 1\n\n";
    text += "f 1 2 3\n";
    if (i > 1) text += "f 1/1/1 2/2/2 3//1 \\\r\n 4\r\ng part\\" + number + "\n";
    if (i > 4) text += "f 5/1 6/2 " + std::to_string(3 * i) + "/3\n";
  }
  return text + "f 36 35 34 33 32\nl 1 2\np 1";
}

/// Everything that a document tells.
std::string account(const Document& document) {
  std::string all;
  const auto add = [&](double value) { all += std::to_string(value) + ' '; };
  for (const Vec3d& p : document.positions()) add(p.x), add(p.y), add(p.z);
  for (const Triangle& t : document.triangles()) add(t[0]), add(t[1]), add(t[2]);
  for (Index v = 0; v < document.positions().size(); ++v) all += document.vertex_place(v) + '\n';
  for (Index t = 0; t < document.triangles().size(); ++t) all += document.triangle_place(t) + '\n';
  const Surface surface = std::move(*prepare_surface(document.positions(), document.triangles(), {}));
  auto after = surface.mesh.positions;
  for (std::size_t v = 0; v < after.size(); v += 3) after[v].z += 0.25F;
  const MovedPositions moved{document.positions(), surface.weld, surface.mesh.positions, after,
                             surface.mesh.frame};
  const auto attributes = document.shared_attributes(moved, {});
  for (const auto& attribute : {attributes->normals, attributes->texture_coordinates}) {
    if (!attribute) continue;
    for (const float value : attribute->values) add(value);
    for (const Triangle& t : attribute->corners) add(t[0]), add(t[1]), add(t[2]);
  }
  for (const float value : attributes->colors) add(value);
  for (const std::string& what : attributes->dropped) all += what + '\n';
  return all + encode(document, moved, {}, {})->bytes;
}

std::string outcome(std::string_view text, const Limits& limits, const RunControl& run,
                    std::uint64_t part_bytes) {
  const auto document = decode_obj(text, limits, run, part_bytes);
  if (document) return account(**document);
  return std::string(cause_code(document.error().cause)) + ": " + document.error().message;
}

void expect_same(std::string_view text, const Limits& limits = {}) {
  const std::string expected = outcome(text, limits, kOneThread, text.size());
  for (const std::uint64_t part_bytes : {1, 7, 64, 200, 1000}) {
    ASSERT_EQ(outcome(text, limits, kTwoThreads, part_bytes), expected) << part_bytes;
  }
}

TEST(ObjParts, ReadEveryKindOfLineAsOneThreadDoes) { expect_same(odd_text()); }

TEST(ObjParts, NameTheSameFirstMistakeWhereverItIs) {
  const std::string text = odd_text();
  for (const char* mistake : {"f 1 2 x\n", "f 1 2\n", "f 1 2 99\n", "f -1 -2 -3\n", "f -900 1 2\n", "v 1 2\n",
                              "v 1 nan 2\n", "f 1/77 2/1 3/1\n", "f 1//78 2//1 3//1\n"}) {
    for (std::size_t at = 0; at != std::string::npos; at = text.find('\n', at + 97)) {
      const std::size_t line = at == 0 ? 0 : at + 1;
      std::string wrong = text.substr(0, line) + mistake + text.substr(line);
      expect_same(wrong);
      wrong.insert(wrong.size() / 2, "\nv 1 2 \"\n");  // a second one, before or behind
      expect_same(wrong);
    }
  }
}

TEST(ObjParts, KeepTheLimits) {
  const std::string text = odd_text();
  for (const std::uint64_t most : {0, 1, 17, 35, 36, 40}) {
    expect_same(text, {.max_vertices = most});
    expect_same(text, {.max_triangles = most});
    expect_same(text, {.max_line_bytes = most});
  }
}

TEST(ObjParts, MeetEveryTruncation) {
  const std::string text = odd_text().substr(0, 700);
  for (std::size_t size = 0; size <= text.size(); ++size) {
    // A copy of its own size, so that the sanitizers see a read beyond the end.
    const std::vector<char> prefix(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size));
    expect_same({prefix.data(), prefix.size()});
  }
}

TEST(ObjParts, TakeLineEndsOfEveryKind) {
  std::string macintosh = odd_text();
  std::erase(macintosh, '\r');
  for (char& c : macintosh) c = c == '\n' ? '\r' : c;
  expect_same(macintosh);
}

TEST(ObjParts, WriteTheSameBytes) {
  for (const std::string& text : {odd_text(), to_obj(with_noise(sphere(3), 0.01))}) {
    const auto document = std::move(*decode_obj(text, {}, kOneThread));
    const Surface surface = std::move(*prepare_surface(document->positions(), document->triangles(), {}));
    auto after = surface.mesh.positions;
    for (Vec3f& p : after) p *= 0.9F;
    const MovedPositions moved{document->positions(), surface.weld, surface.mesh.positions, after,
                               surface.mesh.frame};
    const auto expected = encode(*document, moved, {}, kOneThread);
    for (const std::uint64_t part_bytes : {1, 7, 64, 1000}) {
      const auto written = encode(*document, moved, {.part_bytes = part_bytes}, kTwoThreads);
      EXPECT_EQ(written->bytes, expected->bytes) << part_bytes;
      EXPECT_EQ(written->quantisation_error, expected->quantisation_error);
    }
  }
}

TEST(ObjParts, StopWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const auto result = decode_obj(odd_text(), {}, {.stop = source.get_token(), .threads = 2}, 64);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().cause, Cause::Cancelled);
}

/// Text with room behind it, as the functions ask.
struct Padded {
  std::string text;
  const char* at;
  explicit Padded(std::string_view number) : text(number) {
    text += '\n';
    text.append(kPlainNumberReach, '7');
    at = text.data();
  }
};

TEST(PlainDecimal, IsTheNearestDouble) {
  std::mt19937_64 random(7);
  int plain = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::size_t whole = random() % 9, decimals = random() % 14;
    std::string text = random() % 2 == 0 ? "-" : "";
    for (std::size_t d = 0; d < whole; ++d) text += static_cast<char>('0' + random() % 10);
    if (random() % 8 != 0) text += '.';
    for (std::size_t d = 0; d < decimals; ++d) text += static_cast<char>('0' + random() % 10);
    Padded padded(text);
    double number = 0;
    if (!read_plain_decimal(padded.at, number) || *padded.at != '\n') continue;
    ++plain;
    const double expected = std::strtod(text.c_str(), nullptr);
    EXPECT_EQ(number, expected) << text;
    EXPECT_EQ(std::signbit(number), std::signbit(expected)) << text;
  }
  EXPECT_GT(plain, 100'000);
}

TEST(PlainDecimal, LeavesTheRestToTheGeneralReader) {
  for (const char* text : {"", "-", ".", "+1", "nan", "inf", "x", "-.", "12345678901234567",
                           "0.12345678901234567", "9999999999999999"}) {
    Padded padded(text);
    const char* const begin = padded.at;
    double number = 3;
    const bool read = read_plain_decimal(padded.at, number);
    EXPECT_TRUE(!read || *padded.at != '\n') << text;
    if (!read) {
      EXPECT_EQ(padded.at, begin) << text;
    }
  }
}

TEST(PlainInteger, ReadsUpToEightDigits) {
  for (const std::uint32_t value : {0U, 7U, 10U, 123U, 99'999'999U, 10'000'000U}) {
    Padded padded(std::to_string(value));
    std::uint32_t number = 1;
    EXPECT_TRUE(read_plain_integer(padded.at, number));
    EXPECT_EQ(number, value);
    EXPECT_EQ(*padded.at, '\n');
  }
  for (const char* text : {"", "-1", "/", "x"}) {
    Padded padded(text);
    std::uint32_t number = 1;
    EXPECT_FALSE(read_plain_integer(padded.at, number)) << text;
  }
}

}  // namespace
}  // namespace burnish
