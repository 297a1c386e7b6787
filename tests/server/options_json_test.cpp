#include "server/http/options_json.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

namespace burnish {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::util::MessageDifferencer;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const SmoothService& service() {
  static const SmoothService kService({.max_iterations = 5000, .max_option_bytes = 2000});
  return kService;
}

Result<v1::SmoothOptions> parse(std::string_view text) { return parse_options_json(text, service()); }

TEST(OptionsJson, ReadsWhatProtobufItselfReads) {
  for (
      const std::string text :
      {R"({})", R"({"method":"taubin","iterations":3,"parameters":{"lambda":0.4,"mu":-0.42}})",
       R"({"method":"laplacian","parameters":{"iterations":7}})",
       R"({"output":{"format":"MESH_FORMAT_DRACO","draco":{"method":"DRACO_METHOD_EDGEBREAKER","positionBits":14,
            "normalBits":0,"textureCoordinateBits":12,"colorBits":8,"genericBits":9,"speed":10}}})",
       R"({"output":{"draco":{"position_bits":14,"texture_coordinate_bits":12}}})", R"({"iterations":20.0})",
       R"({"pinned":{"vertices":[0,7,4294967295,7],"group":"rim","attribute":"31"}})",
       R"({"pinned":{"vertices":[]}})", R"({"iterations":0})", R"({"iterations":2e3})"}) {
    const auto read = parse(text);
    ASSERT_TRUE(read.ok()) << text << read.error().message;
    v1::SmoothOptions expected;
    ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(text, &expected).ok()) << text;
    EXPECT_TRUE(MessageDifferencer::Equals(*read, expected)) << text << "\n" << read->DebugString();
  }
}

TEST(OptionsJson, ReadsEnumsByShortNames) {
  const auto obj = parse(R"({"output":{"format":"obj","draco":{"method":"sequential"}}})");
  ASSERT_TRUE(obj.ok()) << obj.error().message;
  EXPECT_EQ(obj->output().format(), v1::MESH_FORMAT_OBJ);
  EXPECT_EQ(obj->output().draco().method(), v1::DRACO_METHOD_SEQUENTIAL);
  for (const char* name : {"drc", "draco", "MESH_FORMAT_DRACO"}) {
    const auto drc = parse(R"({"output":{"format":")" + std::string(name) + R"("}})");
    ASSERT_TRUE(drc.ok()) << name;
    EXPECT_EQ(drc->output().format(), v1::MESH_FORMAT_DRACO);
  }
}

TEST(OptionsJson, NamesThePathOfWhatIsWrong) {
  struct Row {
    std::string text;
    Cause cause;
    const char *field, *says;
  };
  const auto bad = Cause::BadOption, unknown = Cause::UnknownOption;
  const Row rows[] = {
      {"[]", bad, "options", "object"},
      {"3", bad, "options", "object"},
      {R"({"colour":"red"})", unknown, "options.colour", "options has method, iterations, parameters"},
      {R"({"Method":"taubin"})", unknown, "options.Method", "no option"},
      {R"({"output":{"draco":{"bits":3}}})", unknown, "options.output.draco.bits",
       "options.output.draco has method, positionBits"},
      {R"({"method":3})", bad, "options.method", "string"},
      {R"({"method":null})", bad, "options.method", "null"},
      {R"({"method":"sanding"})", Cause::UnknownMethod, "options.method", "sanding"},
      {R"({"iterations":-1})", bad, "options.iterations", "whole number"},
      {R"({"iterations":1.5})", bad, "options.iterations", "whole number"},
      {R"({"iterations":1e300})", bad, "options.iterations", "whole number"},
      {R"({"iterations":4294967296})", bad, "options.iterations", "whole number"},
      {R"({"iterations":18446744073709551616})", bad, "options.iterations", "whole number"},
      {R"({"iterations":-9223372036854775809})", bad, "options.iterations", "whole number"},
      {R"({"iterations":"3"})", bad, "options.iterations", "whole number"},
      {R"({"iterations":true})", bad, "options.iterations", "whole number"},
      {R"({"iterations":[3]})", bad, "options.iterations", "whole number"},
      {R"({"iterations":4294967295})", bad, "options.iterations", "4294967295"},
      {R"({"iterations":5001})", bad, "options.iterations", "(max-iterations)"},
      {R"({"iterations":3,"iterations":3})", bad, "options.iterations", "twice"},
      {R"({"iterations":3,"parameters":{"iterations":3}})", bad, "options.iterations", "twice"},
      {R"({"parameters":[]})", bad, "options.parameters", "object"},
      {R"({"parameters":{"sigma":{}}})", bad, "options.parameters.sigma", "number or a string"},
      {R"({"parameters":{"sigma":true}})", bad, "options.parameters.sigma", "number or a string"},
      {R"({"parameters":{"sigma":1e999}})", bad, "options.parameters.sigma", "overflow"},
      {R"({"parameters":{"shine":1}})", unknown, "options.parameters.shine", "shine"},
      {R"({"method":"taubin","parameters":{"lambda":5}})", bad, "options.parameters.lambda", "lambda"},
      {R"({"output":3})", bad, "options.output", "object"},
      {R"({"output":{"format":"3mf"}})", bad, "options.output.format", "\"obj\""},
      {R"({"output":{"format":2}})", bad, "options.output.format", "\"drc\""},
      {R"({"output":{"draco":{"positionBits":31}}})", bad, "options.output.draco.position_bits", "31"},
      {R"({"output":{"draco":{"positionBits":4294967296}}})", bad, "options.output.draco.positionBits",
       "whole"},
      {R"({"output":{"draco":{"positionBits":9,"position_bits":9}}})", bad,
       "options.output.draco.position_bits", "both of its names"},
      {R"({"pinned":[1]})", bad, "options.pinned", "object"},
      {R"({"pinned":{"vertex":[1]}})", unknown, "options.pinned.vertex", "no option"},
      {R"({"pinned":{"vertices":1}})", bad, "options.pinned.vertices", "array of whole numbers"},
      {R"({"pinned":{"vertices":{"0":1}}})", bad, "options.pinned.vertices", "array of whole numbers"},
      {R"({"pinned":{"vertices":[0,1,-1]}})", bad, "options.pinned.vertices[2]", "whole number from 0"},
      {R"({"pinned":{"vertices":["0"]}})", bad, "options.pinned.vertices[0]", "whole number"},
      {R"({"pinned":{"vertices":[0,[1]]}})", bad, "options.pinned.vertices[1]", "whole number"},
      {R"({"pinned":{"vertices":[0,null]}})", bad, "options.pinned.vertices[1]", "null"},
      {R"({"pinned":{"group":["a"]}})", bad, "options.pinned.group", "string"},
      {R"({"pinned":{"attribute":31}})", bad, "options.pinned.attribute", "string"},
      {R"({"method":"a\u0000b"})", Cause::UnknownMethod, "options.method", "no method"},
  };
  for (const Row& row : rows) {
    const auto read = parse(row.text);
    ASSERT_FALSE(read.ok()) << row.text;
    EXPECT_EQ(read.error().cause, row.cause) << row.text << read.error().message;
    EXPECT_EQ(read.error().field, row.field) << row.text;
    EXPECT_THAT(read.error().message, HasSubstr(row.says)) << row.text;
    EXPECT_THAT(read.error().message, HasSubstr(row.field)) << row.text;
  }
}

TEST(OptionsJson, BoundsItsSize) {
  const auto refused = parse(R"({"method":")" + std::string(2000, 'x') + R"("})");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().cause, Cause::TooLarge);
  EXPECT_THAT(refused.error().message, HasSubstr("(max-option-bytes)"));
}

/// Every field of the options, however deep.
void visit(const google::protobuf::Descriptor& type,
           const std::function<void(const FieldDescriptor&)>& visitor) {
  for (int i = 0; i < type.field_count(); ++i) {
    visitor(*type.field(i));
    const auto* const message = type.field(i)->message_type();
    if (message && !type.field(i)->is_map()) visit(*message, visitor);
  }
}

TEST(OptionsJson, KnowsTheTypeOfEveryOption) {
  int fields = 0;
  visit(*v1::SmoothOptions::descriptor(), [&](const FieldDescriptor& field) {
    ++fields;
    EXPECT_TRUE(!field.is_repeated() || field.is_map() || field.cpp_type() == FieldDescriptor::CPPTYPE_UINT32)
        << field.full_name();
    EXPECT_TRUE(field.is_map() || field.cpp_type() == FieldDescriptor::CPPTYPE_UINT32 ||
                field.cpp_type() == FieldDescriptor::CPPTYPE_STRING ||
                field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM ||
                field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE)
        << field.full_name();
  });
  EXPECT_GE(fields, 13);
}

}  // namespace
}  // namespace burnish
