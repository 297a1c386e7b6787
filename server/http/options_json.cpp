#include "server/http/options_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "server/http/strict_json.h"

namespace burnish {
namespace {

using Json = nlohmann::json;
using google::protobuf::EnumDescriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr const char* kRoot = "options";

Error expected(const std::string& place, const std::string& what) {
  return {Cause::BadOption, place + " must be " + what, place};
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// MESH_FORMAT_OBJ is "obj": what MESH_FORMAT_UNSPECIFIED shares with it is cut. Draco is also "drc", as
/// everywhere else.
std::map<std::string, const EnumValueDescriptor*> short_values(const EnumDescriptor& type) {
  const std::size_t prefix = type.value(0)->name().size() - std::string_view("UNSPECIFIED").size();
  std::map<std::string, const EnumValueDescriptor*> values;
  for (int i = 1; i < type.value_count(); ++i) {
    values[lower_case(type.value(i)->name().substr(prefix))] = type.value(i);
  }
  if (&type == v1::MeshFormat_descriptor())
    values[std::string(format_name(Format::Draco))] = values.at("draco");
  return values;
}

const EnumValueDescriptor* find_value(const EnumDescriptor& type, const std::string& name) {
  if (const auto* value = type.FindValueByName(name)) return value;
  const auto values = short_values(type);
  const auto found = values.find(name);
  return found == values.end() ? nullptr : found->second;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "\"" : " or \"") + name + '"';
  return list;
}

Result<std::uint32_t> whole_number(const Json& from, const std::string& place) {
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
  const double value = from.is_number() ? from.get<double>() : -1;
  if (!(value >= 0 && value <= kMost) || std::floor(value) != value) {
    return expected(place, "a whole number from 0 to 4294967295");
  }
  return static_cast<std::uint32_t>(value);
}

Result<> read_uint32(const Json& from, Message& into, const FieldDescriptor& field,
                     const std::string& place) {
  const auto number = whole_number(from, place);
  if (!number) return number.error();
  into.GetReflection()->SetUInt32(&into, &field, *number);
  return {};
}

Result<> read_string(const Json& from, Message& into, const FieldDescriptor& field,
                     const std::string& place) {
  if (!from.is_string()) return expected(place, "a string");
  into.GetReflection()->SetString(&into, &field, from.get<std::string>());
  return {};
}

Result<> read_enum(const Json& from, Message& into, const FieldDescriptor& field, const std::string& place) {
  const auto* value = from.is_string() ? find_value(*field.enum_type(), from.get<std::string>()) : nullptr;
  if (!value) return expected(place, list_of(short_names(*field.enum_type())));
  into.GetReflection()->SetEnum(&into, &field, value);
  return {};
}

std::string member_of(const std::string& place, const std::string& name) { return place + '.' + name; }

/// The only map of the options holds parameters.
Result<> read_map(const Json& from, Message& into, const FieldDescriptor& field, const std::string& place) {
  if (!from.is_object()) return expected(place, "an object");
  for (const auto& [name, value] : from.items()) {
    if (!value.is_number() && !value.is_string())
      return expected(member_of(place, name), "a number or a string");
    Message& entry = *into.GetReflection()->AddMessage(&into, &field);
    const auto& members = *field.message_type();
    entry.GetReflection()->SetString(&entry, members.map_key(), name);
    auto& held = static_cast<google::protobuf::Value&>(
        *entry.GetReflection()->MutableMessage(&entry, members.map_value()));
    if (value.is_string()) {
      held.set_string_value(value.get<std::string>());
    } else {
      held.set_number_value(value.get<double>());
    }
  }
  return {};
}

Result<> read_message(const Json& from, Message& into, const std::string& place);

/// Lists of the options hold whole numbers.
Result<> read_list(const Json& from, Message& into, const FieldDescriptor& field, const std::string& place) {
  if (!from.is_array()) return expected(place, "an array of whole numbers");
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto number = whole_number(from[i], place + '[' + std::to_string(i) + ']');
    if (!number) return number.error();
    into.GetReflection()->AddUInt32(&into, &field, *number);
  }
  return {};
}

Result<> read_field(const Json& from, Message& into, const FieldDescriptor& field, const std::string& place) {
  if (field.is_map()) return read_map(from, into, field, place);
  if (field.is_repeated()) return read_list(from, into, field, place);
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_UINT32:
      return read_uint32(from, into, field, place);
    case FieldDescriptor::CPPTYPE_STRING:
      return read_string(from, into, field, place);
    case FieldDescriptor::CPPTYPE_ENUM:
      return read_enum(from, into, field, place);
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return read_message(from, *into.GetReflection()->MutableMessage(&into, &field), place);
    default:
      return Error{Cause::Internal, place + " has a type that the server cannot read", place};
  }
}

const FieldDescriptor* find_field(const Message& message, const std::string& name) {
  const auto& type = *message.GetDescriptor();
  const auto* field = type.FindFieldByName(name);
  for (int i = 0; !field && i < type.field_count(); ++i) {
    if (type.field(i)->json_name() == name) field = type.field(i);
  }
  return field;
}

std::string names_of_fields(const Message& message) {
  const auto& type = *message.GetDescriptor();
  std::string names;
  for (int i = 0; i < type.field_count(); ++i) names += (i > 0 ? ", " : "") + type.field(i)->json_name();
  return names;
}

Result<> read_message(const Json& from, Message& into, const std::string& place) {
  if (!from.is_object()) return expected(place, "an object");
  std::set<const FieldDescriptor*> seen;
  for (const auto& [name, value] : from.items()) {
    const std::string member = member_of(place, name);
    const FieldDescriptor* const field = find_field(into, name);
    if (!field) {
      return Error{Cause::UnknownOption,
                   "there is no option " + member + "; " + place + " has " + names_of_fields(into), member};
    }
    if (!seen.insert(field).second) {
      return Error{Cause::BadOption, member + " is given twice, under both of its names", member};
    }
    if (auto read = read_field(value, into, *field, member); !read) return read;
  }
  return {};
}

/// The service knows parameters by their names alone, and output options by the contract's.
Error located(Error error) {
  const bool parameter = !error.field.empty() && error.field != "method" && error.field != "iterations" &&
                         !error.field.starts_with("output.");
  error.field = std::string(kRoot) +
                (parameter             ? ".parameters."
                 : error.field.empty() ? ""
                                       : ".") +
                error.field;
  error.message = error.field + ": " + error.message;
  return error;
}

}  // namespace

std::vector<std::string> short_names(const EnumDescriptor& type) {
  std::vector<std::string> names;
  for (const auto& [name, value] : short_values(type)) names.push_back(name);
  return names;
}

Result<v1::SmoothOptions> parse_options_json(std::string_view text, const SmoothService& service) {
  if (const auto most = service.limits().max_option_bytes; text.size() > most) {
    return Error{Cause::TooLarge,
                 "options has " + std::to_string(text.size()) + " bytes; the limit is " +
                     std::to_string(most) + " (max-option-bytes)",
                 kRoot};
  }
  const auto json = parse_strict_json(text, kRoot);
  if (!json) return json.error();
  v1::SmoothOptions options;
  if (auto read = read_message(*json, options, kRoot); !read) return read.error();
  if (auto fine = service.check(options); !fine) return located(fine.error());
  return options;
}

}  // namespace burnish
