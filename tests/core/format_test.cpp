#include "core/io/format.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "core/io/codec.h"
#include "core/io/estimate.h"
#include "tests/core/format_fixture.h"
#include "tests/support/shapes.h"

namespace burnish::testing {
namespace {

std::string binary_stl(std::string header, std::uint32_t facets, std::size_t more = 0) {
  header.resize(80, ' ');
  for (int shift = 0; shift < 32; shift += 8) header += static_cast<char>(facets >> shift);
  return header + std::string(50 * std::size_t{facets} + more, '\0');
}

TEST(Format, IsToldByContent) {
  struct Row {
    std::string bytes;
    std::optional<Format> format;
  };
  const Row rows[] = {
      {"v 0 0 0\n", Format::Obj},
      {"", Format::Obj},
      {"# OFF\nv 0 0 0\n", Format::Obj},
      {"DRACO\2\2", Format::Draco},
      {"DRACO", Format::Draco},
      {"ply\nformat ascii 1.0\n", Format::Ply},
      {"ply\r\nformat ascii 1.0\r\n", Format::Ply},
      {"ply", Format::Ply},
      {"plywood 1\nv 0 0 0\n", Format::Obj},
      {"glTF\2\0\0\0", Format::Glb},
      {"solid cube\n facet normal 0 0 1\n", Format::Stl},
      {"\n  SOLID\n  FACET NORMAL 0 0 1\n", Format::Stl},
      {"solid", Format::Stl},
      {"solid cube\nendsolid cube\n", Format::Stl},
      {"solid cube\nv 0 0 0\n", Format::Obj},
      {"solidify 1\nv 0 0 0\n", Format::Obj},
      {"OFF\n3 1 0\n", Format::Off},
      {"# a comment\n\n  COFF # more\n3 1 0\n", Format::Off},
      {"OFF#\n", Format::Off},
      {"STCN4nOFF\n", Format::Off},
      {std::string("OFF BINARY\n\0\0\0\3", 15), Format::Off},
      {"OFFSET 1\nv 0 0 0\n", Format::Obj},
      {std::string("\0\1\2\3", 4), std::nullopt},
      {std::string("v 0 0 0\0", 8), std::nullopt},
  };
  for (const Row& row : rows) EXPECT_EQ(detect_format(row.bytes), row.format) << row.bytes;
}

TEST(Format, OfABinaryStlIsToldByItsSizeWhateverItsHeaderSays) {
  for (const char* header :
       {"", "solid cube", "solid", "DRACO by hand", "glTF export", "OFF", "v 0 0 0\n# ", "plywood"}) {
    for (const std::uint32_t facets : {0U, 1U, 12U}) {
      EXPECT_EQ(detect_format(binary_stl(header, facets)), Format::Stl) << header << ' ' << facets;
    }
    EXPECT_EQ(detect_format(binary_stl(header, 3, 2)), Format::Stl) << header << ", with two bytes behind";
  }
  EXPECT_EQ(detect_format(binary_stl("by a scanner", 3, 50)), std::nullopt);
}

/// A tetrahedron in every format that may be text.
const std::map<Format, std::string>& texts() {
  static const std::map<Format, std::string> kTexts = [] {
    const std::string points[] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
    const int faces[][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    std::string obj, lists, stl = "solid of text\n";
    for (const std::string& point : points) obj += "v " + point + "\n", lists += point + "\n";
    for (const auto& [a, b, c] : faces) {
      obj += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
      lists += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
      stl += "facet normal 0 0 0\nouter loop\n";
      for (const int corner : {a, b, c}) stl += "vertex " + points[corner] + "\n";
      stl += "endloop\nendfacet\n";
    }
    return std::map<Format, std::string>{
        {Format::Obj, obj},
        {Format::Off, "OFF\n4 4 6\n" + lists},
        {Format::Ply,
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
         "z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n" +
             lists},
        {Format::Stl, stl + "endsolid of text\n"}};
  }();
  return kTexts;
}

TEST(ByteOrderMark, IsNotPartOfTheTextBehindIt) {
  for (const auto& [format, text] : texts()) {
    const std::string marked = std::string(kByteOrderMark) + text;
    EXPECT_EQ(detect_format(marked), format);
    const LoadedFile plain(text), file(marked);
    EXPECT_TRUE(std::ranges::equal(file.document->positions(), plain.document->positions()));
    EXPECT_TRUE(std::ranges::equal(file.document->triangles(), plain.document->triangles()));
    EXPECT_EQ(file.document->vertex_place(3), plain.document->vertex_place(3)) << "the mark is in no line";
    EXPECT_EQ(estimate(marked, format).triangles, estimate(text, format).triangles);
    EXPECT_EQ(error_of(std::string(kByteOrderMark) + "nothing like it", format).message,
              error_of("nothing like it", format).message);
  }
}

TEST(ByteOrderMark, StaysBeforeTheSameFormatOnly) {
  for (const auto& [format, text] : texts()) {
    LoadedFile plain(text), file(std::string(kByteOrderMark) + text);
    EXPECT_EQ(file.written(), file.bytes) << "what did not move comes back to the byte";
    plain.move_all(), file.move_all();
    EXPECT_EQ(file.written(), std::string(kByteOrderMark) + plain.written());
    for (const FormatTraits& other : formats()) {
      if (other.format == format) continue;
      EXPECT_EQ(file.written(other.format), plain.written(other.format)) << other.name;
    }
  }
}

TEST(ByteOrderMark, IsNoneInTheHeaderOfABinaryStl) {
  const std::string marked = binary_stl(std::string(kByteOrderMark) + "by a scanner", 12);
  EXPECT_EQ(detect_format(marked), Format::Stl);
  EXPECT_EQ(behind_byte_order_mark(marked, Format::Stl), marked);
  EXPECT_EQ(behind_byte_order_mark("\xEF\xBB\xBF"
                                   "DRACO",
                                   Format::Draco),
            "\xEF\xBB\xBF"
            "DRACO");
}

TEST(ByteOrderMark, CutOffIsNone) {
  for (const std::size_t size : {1, 2})
    EXPECT_EQ(behind_byte_order_mark(kByteOrderMark.substr(0, size), Format::Obj).size(), size);
  EXPECT_EQ(error_of(kByteOrderMark, Format::Obj).message, error_of("", Format::Obj).message);
}

TEST(Format, OfABinaryStlThatWasCutOffIsToldByItsHeaderOfText) {
  for (const std::string& header :
       {std::string(), std::string("by a scanner"), std::string("solid, but cut off"),
        "by a scanner" + std::string(68, '\0'), std::string(80, '\0')}) {
    const std::string whole = binary_stl(header, 3);
    for (const std::size_t size : {whole.size() - 1, std::size_t{200}, std::size_t{84}})
      EXPECT_EQ(detect_format(whole.substr(0, size)), Format::Stl) << header << ", " << size << " bytes";
  }
  EXPECT_EQ(detect_format(binary_stl("by a scanner", 0, 150)), std::nullopt);
  EXPECT_EQ(detect_format(binary_stl("by no \1scanner", 3).substr(0, 200)), std::nullopt);
  EXPECT_EQ(detect_format(binary_stl(std::string("padded by\0", 10), 3).substr(0, 200)), std::nullopt);
}

TEST(Format, OfAnyTextObjIsObj) {
  const std::string text = to_obj(sphere(2));
  for (std::size_t size = 0; size < text.size(); ++size)
    ASSERT_EQ(detect_format(text.substr(0, size)), Format::Obj);
}

TEST(Format, HasNamesAndMediaTypesOfItsOwn) {
  std::set<std::string_view> seen;
  for (const FormatTraits& each : formats()) {
    EXPECT_EQ(format_named(each.name), each.format);
    EXPECT_EQ(format_of_media_type(each.media_type), each.format);
    EXPECT_EQ(&traits_of(each.format), &each);
    EXPECT_TRUE(seen.insert(each.name).second && seen.insert(each.media_type).second) << each.name;
    for (const std::string_view other : each.other_media_types) {
      EXPECT_EQ(format_of_media_type(other), each.format);
      EXPECT_TRUE(seen.insert(other).second) << other;
    }
  }
  EXPECT_EQ(format_named("OBJ"), std::nullopt);
  EXPECT_EQ(format_of_media_type("text/plain"), std::nullopt);
  EXPECT_EQ(list_of_format_names(), "obj, drc, ply, stl, off or glb");
}

}  // namespace
}  // namespace burnish::testing
