#include <cmath>
#include <map>
#include <string>

#include <absl/strings/escaping.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <nlohmann/json.hpp>

#include "server/service/smooth_service.h"

namespace burnish {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Json = nlohmann::ordered_json;

Json json_of(const Message& message);

/// A whole number without ".0"; what JSON has no number for as its name.
Json number(double value) {
  constexpr double kExponent = 1e15;  // from here on with one
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "Infinity" : "-Infinity";
  if (value == std::floor(value) && std::abs(value) < kExponent) return static_cast<std::int64_t>(value);
  return value;
}

/// The value of a field, or of its element `at` when it is repeated.
Json value_of(const Message& message, const FieldDescriptor& field, int at) {
  const Reflection& from = *message.GetReflection();
  const bool one = !field.is_repeated();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return one ? from.GetInt32(message, &field) : from.GetRepeatedInt32(message, &field, at);
    case FieldDescriptor::CPPTYPE_UINT32:
      return one ? from.GetUInt32(message, &field) : from.GetRepeatedUInt32(message, &field, at);
    case FieldDescriptor::CPPTYPE_INT64:  // as text, for it may be more than a number of JavaScript holds
      return std::to_string(one ? from.GetInt64(message, &field)
                                : from.GetRepeatedInt64(message, &field, at));
    case FieldDescriptor::CPPTYPE_UINT64:
      return std::to_string(one ? from.GetUInt64(message, &field)
                                : from.GetRepeatedUInt64(message, &field, at));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return number(one ? from.GetDouble(message, &field) : from.GetRepeatedDouble(message, &field, at));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return number(one ? from.GetFloat(message, &field) : from.GetRepeatedFloat(message, &field, at));
    case FieldDescriptor::CPPTYPE_BOOL:
      return one ? from.GetBool(message, &field) : from.GetRepeatedBool(message, &field, at);
    case FieldDescriptor::CPPTYPE_ENUM:
      return (one ? from.GetEnum(message, &field) : from.GetRepeatedEnum(message, &field, at))->name();
    case FieldDescriptor::CPPTYPE_STRING: {
      std::string text = one ? from.GetString(message, &field) : from.GetRepeatedString(message, &field, at);
      return field.type() == FieldDescriptor::TYPE_BYTES ? absl::Base64Escape(text) : text;
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return json_of(one ? from.GetMessage(message, &field) : from.GetRepeatedMessage(message, &field, at));
  }
  return nullptr;
}

/// A map of names, in alphabetical order: protobuf's own changes from run to run.
Json map_of(const Message& message, const FieldDescriptor& field) {
  std::map<std::string, Json> entries;
  for (int i = 0; i < message.GetReflection()->FieldSize(message, &field); ++i) {
    const Message& entry = message.GetReflection()->GetRepeatedMessage(message, &field, i);
    entries.emplace(entry.GetReflection()->GetString(entry, field.message_type()->map_key()),
                    value_of(entry, *field.message_type()->map_value(), 0));
  }
  Json json = Json::object();
  for (auto& [name, value] : entries) json[name] = std::move(value);
  return json;
}

Json list_of(const Message& message, const FieldDescriptor& field) {
  Json json = Json::array();
  for (int i = 0; i < message.GetReflection()->FieldSize(message, &field); ++i)
    json.push_back(value_of(message, field, i));
  return json;
}

/// Of protobuf's types that have a form of their own, such as a time.
Json well_known(const Message& message) {
  if (const auto* value = dynamic_cast<const google::protobuf::Value*>(&message)) {
    if (value->has_number_value()) return number(value->number_value());
    if (value->has_string_value()) return value->string_value();
  }
  std::string text;
  // Fails only for what JSON has no word for, such as a time behind the year 9999; ours never hold any.
  if (!google::protobuf::util::MessageToJsonString(message, &text).ok()) return nullptr;
  return Json::parse(text);
}

/// By reflection: protobuf's own printer takes half a millisecond for a report, as long as the copies of a
/// mesh.
Json json_of(const Message& message) {
  const google::protobuf::Descriptor& type = *message.GetDescriptor();
  if (type.file()->package() == "google.protobuf") return well_known(message);
  Json json = Json::object();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (field.is_map()) {
      json[field.json_name()] = map_of(message, field);
    } else if (field.is_repeated()) {
      json[field.json_name()] = list_of(message, field);
    } else if (!field.has_presence() || message.GetReflection()->HasField(message, &field)) {
      json[field.json_name()] = value_of(message, field, 0);
    }
  }
  return json;
}

}  // namespace

std::string to_json(const Message& message, bool compact) {
  return json_of(message).dump(compact ? -1 : 2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace burnish
