// The JSON of messages is that of protobuf's own printer, with maps in the order of their names.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/timestamp.pb.h>
#include <google/protobuf/util/json_util.h>
#include <nlohmann/json.hpp>

#include "burnish/v1/jobs.pb.h"
#include "server/service/smooth_service.h"

namespace burnish::testing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using Json = nlohmann::ordered_json;

void sort_maps(Json& json) {
  if (!json.is_structured()) return;
  for (auto& [name, value] : json.items()) {
    sort_maps(value);
    if (name != "parameters" || !value.is_object()) continue;
    std::map<std::string, Json> sorted;
    for (const auto& [key, entry] : value.items()) sorted.emplace(key, entry);
    value = Json(sorted);
  }
}

/// Protobuf writes times last, wherever they are declared.
std::string in_order(const std::string& json) { return nlohmann::json::parse(json).dump(); }

std::string by_protobuf(const Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  std::string text;
  EXPECT_TRUE(google::protobuf::util::MessageToJsonString(message, &text, options).ok());
  Json json = Json::parse(text);
  sort_maps(json);
  return json.dump();
}

/// Fills messages of any type, about half of their fields.
class Filler {
 public:
  explicit Filler(unsigned seed) : random_(seed) {}

  void fill(Message& message, int depth = 0) {
    if (auto* time = dynamic_cast<google::protobuf::Timestamp*>(&message)) {
      time->set_seconds(static_cast<std::int64_t>(random_()));
      time->set_nanos(static_cast<int>(below(1'000'000'000)));
      return;
    }
    if (auto* value = dynamic_cast<google::protobuf::Value*>(&message)) {
      below(2) == 0 ? value->set_number_value(number()) : value->set_string_value(text());
      return;
    }
    for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
      const FieldDescriptor& field = *message.GetDescriptor()->field(i);
      const bool needed =
          message.GetDescriptor()->options().map_entry();  // of which neither half is left out
      const std::size_t times = field.is_repeated() ? below(4) : needed ? std::size_t{1} : below(2);
      for (std::size_t n = 0; n < times; ++n) set(message, field, depth);
    }
  }

 private:
  std::size_t below(std::size_t bound) { return random_() % bound; }
  double number() {
    constexpr std::array kNumbers{
        0.0,  -0.0, 1.0,    -3.0,    0.1,       1e-7,   123456789.25, 999999999999999.0,
        1e15, 1e20, 5e-324, 1.7e308, 1.0 / 3.0, 2.5e-5, 1e5};
    return kNumbers[below(kNumbers.size())];
  }
  std::string text() {
    constexpr std::array kTexts{"",     "lambda", "\"quoted\" \\ <&>", "line\nend\t\x01", "größer — 網格",
                                "a\x7f"};
    return kTexts[below(kTexts.size())] + std::to_string(below(1000));
  }

  void set(Message& message, const FieldDescriptor& field, int depth) {
    const auto& to = *message.GetReflection();
    const bool one = !field.is_repeated();
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_UINT32:
        return one ? to.SetUInt32(&message, &field, random_()) : to.AddUInt32(&message, &field, random_());
      case FieldDescriptor::CPPTYPE_UINT64: {
        const std::uint64_t large = std::uint64_t{random_()} << 31;
        return one ? to.SetUInt64(&message, &field, large) : to.AddUInt64(&message, &field, large);
      }
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return one ? to.SetDouble(&message, &field, number()) : to.AddDouble(&message, &field, number());
      case FieldDescriptor::CPPTYPE_BOOL:
        return one ? to.SetBool(&message, &field, true) : to.AddBool(&message, &field, true);
      case FieldDescriptor::CPPTYPE_ENUM: {
        const auto* value = field.enum_type()->value(
            static_cast<int>(below(static_cast<std::size_t>(field.enum_type()->value_count()))));
        return one ? to.SetEnum(&message, &field, value) : to.AddEnum(&message, &field, value);
      }
      case FieldDescriptor::CPPTYPE_STRING:
        return one ? to.SetString(&message, &field, text()) : to.AddString(&message, &field, text());
      case FieldDescriptor::CPPTYPE_MESSAGE:
        if (depth < 5)
          fill(one ? *to.MutableMessage(&message, &field) : *to.AddMessage(&message, &field), depth + 1);
        return;
      default:
        FAIL() << field.full_name() << " is of a type that this test does not fill";
    }
  }

  std::mt19937 random_;
};

template <class T>
class JsonOf : public ::testing::Test {};
using Printed =
    ::testing::Types<v1::SmoothReport, v1::SmoothResponse, v1::CompareResponse, v1::ListMethodsResponse,
                     v1::SmoothOptions, v1::Job, v1::ListJobsResponse, v1::Upload>;
TYPED_TEST_SUITE(JsonOf, Printed);

TYPED_TEST(JsonOf, AnEmptyMessageIsThatOfProtobuf) {
  EXPECT_EQ(to_json(TypeParam(), true), by_protobuf(TypeParam()));
}

TYPED_TEST(JsonOf, AnyMessageIsThatOfProtobuf) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    TypeParam message;
    Filler(seed).fill(message);
    ASSERT_EQ(in_order(to_json(message, true)), in_order(by_protobuf(message))) << seed;
    EXPECT_EQ(Json::parse(to_json(message, false)), Json::parse(to_json(message, true)));
  }
}

TEST(JsonOfNumbers, HasAWordForWhatIsNone) {
  v1::MeshErrors errors;
  errors.set_max_distance(std::numeric_limits<double>::infinity());
  errors.set_mean_distance(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(to_json(errors, true), by_protobuf(errors));
}

}  // namespace
}  // namespace burnish::testing
