#include "server/http/strict_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace burnish {
namespace {

using ::testing::HasSubstr;

std::string nested(std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); }

TEST(StrictJson, ReadsWhatIsJson) {
  for (const std::string text :
       {"{}", "[]", " 3 ", "\"x\"", "true", R"({"a":[1,-2,3.5e2,"\u00fc",{"b":false}],"c":{}})",
        R"([[],[[]],{"a":[]}])"}) {
    const auto read = parse_strict_json(text, "root");
    ASSERT_TRUE(read.ok()) << text << read.error().message;
    EXPECT_EQ(*read, nlohmann::json::parse(text));
  }
  EXPECT_TRUE(parse_strict_json(nested(kDeepestJson), "root").ok());
}

TEST(StrictJson, NamesThePlaceOfWhatIsWrong) {
  struct Row {
    std::string text;
    const char *field, *says;
  };
  std::string deepest = "root.a";
  for (std::size_t i = 1; i < kDeepestJson; ++i) deepest += "[0]";
  const Row rows[] = {
      {"", "root", "not valid"},
      {"{", "root", "not valid"},
      {"{} x", "root", "not valid"},
      {"{}{}", "root", "not valid"},
      {"{\"a\":1,}", "root", "not valid"},
      {"{a:1}", "root", "not valid"},
      {"{'a':1}", "root", "not valid"},
      {"// no comments\n{}", "root", "not valid"},
      {"[01]", "root", "not valid"},
      {"[NaN]", "root", "not valid"},
      {"[Infinity]", "root", "not valid"},
      {"\"\xff\"", "root", "not valid"},
      {"\"\xc3\"", "root", "not valid"},
      {"\"\\ud800\"", "root", "not valid"},
      {"\"a\nb\"", "root", "not valid"},
      {std::string("{\"a\":1}\0 x", 10), "root", "NUL"},
      {"null", "root", "null"},
      {R"({"a":{"b":null}})", "root.a.b", "null"},
      {R"({"a":[1,[2,null]]})", "root.a[1][1]", "null"},
      {R"({"a":1,"b":2,"a":1})", "root.a", "twice"},
      {R"({"o":{"p":[{},{"x":1,"\u0078":2}]}})", "root.o.p[1].x", "twice"},
      {R"({"a":{"b":1},"c":{"b":1},"a":2})", "root.a", "twice"},
      {R"({"a":[1e999]})", "root.a[0]", "overflow"},
      {R"({"a":)" + nested(kDeepestJson) + "}", deepest.c_str(), "deeper than 32"},
  };
  for (const Row& row : rows) {
    const auto read = parse_strict_json(row.text, "root");
    ASSERT_FALSE(read.ok()) << row.text;
    EXPECT_EQ(read.error().cause, Cause::BadOption);
    EXPECT_THAT(read.error().message, HasSubstr(row.says)) << row.text;
    EXPECT_EQ(read.error().field, row.field) << row.text;
    EXPECT_THAT(read.error().message, ::testing::StartsWith(read.error().field));
  }
}

// Parsing that deep is fine for nlohmann::json; printing, copying or comparing the result ends the process.
TEST(StrictJson, RefusesAMillionNestedArraysOrObjects) {
  EXPECT_THAT(parse_strict_json(std::string(1'000'000, '['), "root").error().message, HasSubstr("deeper"));
  std::string objects;
  for (int i = 0; i < 1'000'000; ++i) objects += "{\"a\":";
  const auto refused = parse_strict_json(objects, "root");
  EXPECT_THAT(refused.error().message, HasSubstr("deeper"));
  EXPECT_THAT(refused.error().field, HasSubstr("root.a.a.a"));
}

TEST(StrictJson, SurvivesEveryPrefixAndEveryByte) {
  const std::string text = R"({"method":"x","p":{"q":[1,-2.5e3,true,"\u00e4\n"]},"r":{}})";
  for (std::size_t length = 0; length < text.size(); ++length) {
    EXPECT_FALSE(parse_strict_json(text.substr(0, length), "root").ok()) << length;
    for (int byte = 0; byte < 256; ++byte) {
      std::string mutant = text;
      mutant[length] = static_cast<char>(byte);
      const auto read = parse_strict_json(mutant, "root");
      EXPECT_TRUE(read.ok() || !read.error().message.empty());
    }
  }
}

}  // namespace
}  // namespace burnish
