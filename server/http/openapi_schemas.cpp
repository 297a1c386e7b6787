#include "server/http/openapi_schemas.h"

#include <algorithm>
#include <map>
#include <vector>

#include "burnish/v1/jobs.pb.h"
#include "burnish/v1/smoothing.pb.h"
#include "core/smooth/registry.h"
#include "server/http/options_json.h"
#include "server/http/smooth_query.h"
#include "server/service/options.h"
#include "server/status_map.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;
using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;

/// Answers print every field that has a value; requests may leave all out, but name no others.
enum class Direction : std::uint8_t { Answer, Request };

constexpr std::uint32_t kMostUint32 = 0xffffffff;

Json parameter_value() { return {{"type", {"number", "string"}}}; }

Json enum_schema(const EnumDescriptor& type, Direction direction) {
  Json names = Json::array();
  for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
  if (direction == Direction::Request) {
    for (const std::string& name : short_names(type)) names.push_back(name);
  }
  return {{"type", "string"}, {"enum", std::move(names)}};
}

Json single_schema(const FieldDescriptor& field, Direction direction) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_UINT32:
      return {{"type", "integer"}, {"minimum", 0}, {"maximum", kMostUint32}};
    case FieldDescriptor::CPPTYPE_BOOL:
      return {{"type", "boolean"}};
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return {{"type", "number"}};
    case FieldDescriptor::CPPTYPE_ENUM:
      return enum_schema(*field.enum_type(), direction);
    case FieldDescriptor::CPPTYPE_MESSAGE:
      if (field.message_type() == google::protobuf::Value::descriptor()) return parameter_value();
      if (field.message_type() == google::protobuf::Timestamp::descriptor())
        return {{"type", "string"}, {"format", "date-time"}};
      return schema_reference(field.message_type()->name());
    default:
      if (field.type() == FieldDescriptor::TYPE_BYTES) {
        return {{"type", "string"}, {"contentEncoding", "base64"}};
      }
      return {{"type", "string"}};
  }
}

Json field_schema(const FieldDescriptor& field, Direction direction) {
  if (field.is_map()) return {{"type", "object"}, {"additionalProperties", parameter_value()}};
  if (field.is_repeated()) return {{"type", "array"}, {"items", single_schema(field, direction)}};
  return single_schema(field, direction);
}

Json message_schema(const Descriptor& type, Direction direction) {
  Json properties = Json::object(), required = Json::array();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    properties[field.json_name()] = field_schema(field, direction);
    if (!field.has_presence()) required.push_back(field.json_name());
  }
  Json schema = {{"type", "object"}, {"properties", std::move(properties)}};
  if (direction == Direction::Request) schema["additionalProperties"] = false;
  if (direction == Direction::Answer && !required.empty()) schema["required"] = std::move(required);
  return schema;
}

/// The message and every message in it, each under its name.
void add_messages(const Descriptor& type, Direction direction, Json& schemas) {
  if (schemas.contains(type.name())) return;
  schemas[type.name()] = message_schema(type, direction);
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE || field.is_map()) continue;
    if (field.message_type()->file() == type.file()) add_messages(*field.message_type(), direction, schemas);
  }
}

Json spec_schema(const ParameterSpec& spec, const RequestLimits& limits) {
  if (spec.kind == ParameterKind::Choice) return {{"type", "string"}, {"enum", spec.choices}};
  const bool whole = spec.kind == ParameterKind::Integer;
  const double most =
      spec.name == "iterations" ? std::min<double>(spec.maximum, limits.max_iterations) : spec.maximum;
  return {{"type", whole ? "integer" : "number"}, {"minimum", spec.minimum}, {"maximum", most}};
}

Json problem_schema() {
  Json codes = Json::array();
  for (const Cause cause : all_causes()) {
    if (comes_from_servers(cause)) codes.push_back(cause_code(cause));
  }
  const Json text = {{"type", "string"}};
  return {
      {"type", "object"},
      {"description", "An error as RFC 9457 has it. Match on code; detail is for people."},
      {"required", {"type", "title", "status", "detail", "code", "requestId"}},
      {"properties",
       {{"type", {{"type", "string"}, {"pattern", "^urn:burnish:problem:[a-z_]+$"}}},
        {"title", text},
        {"status", {{"type", "integer"}, {"minimum", 400}, {"maximum", 599}}},
        {"detail", text},
        {"code", {{"type", "string"}, {"enum", std::move(codes)}}},
        {"requestId", text},
        {"field",
         {{"type", "string"}, {"description", "The option, query parameter or part that is to blame."}}}}}};
}

void describe_options(Json& schemas, const RequestLimits& limits) {
  Json names = Json::array();
  for (const Method& method : methods()) names.push_back(method.name);
  Json& options = schemas["SmoothOptions"];
  options["description"] = "How to smooth and how to write the result, at most " +
                           std::to_string(limits.max_option_bytes) +
                           " bytes. Names may also be written in snake_case.";
  options["properties"]["method"] = {{"type", "string"}, {"enum", names}, {"default", names[0]}};
  options["properties"]["iterations"]["maximum"] = limits.max_iterations;
  for (const DracoNumber& number : kDracoNumbers) {
    const auto& field = *v1::DracoOptions::descriptor()->FindFieldByName(number.name);
    schemas["DracoOptions"]["properties"][field.json_name()]["maximum"] = number.most;
  }
  options["properties"]["parameters"] = {
      {"type", "object"}, {"properties", method_parameter_schemas(limits)}, {"additionalProperties", false}};
}

}  // namespace

Json schema_reference(const std::string& name) { return {{"$ref", "#/components/schemas/" + name}}; }

Json openapi_schemas(const RequestLimits& limits) {
  Json schemas = Json::object();
  add_messages(*v1::SmoothResponse::descriptor(), Direction::Answer, schemas);
  add_messages(*v1::CompareResponse::descriptor(), Direction::Answer, schemas);
  add_messages(*v1::ListMethodsResponse::descriptor(), Direction::Answer, schemas);
  add_messages(*v1::SmoothOptions::descriptor(), Direction::Request, schemas);
  add_messages(*v1::SmoothProgress::descriptor(), Direction::Answer, schemas);
  add_messages(*v1::ListJobsResponse::descriptor(), Direction::Answer, schemas);
  add_messages(*v1::Upload::descriptor(), Direction::Answer, schemas);
  describe_options(schemas, limits);
  schemas["Problem"] = problem_schema();
  return schemas;
}

Json method_parameter_schemas(const RequestLimits& limits) {
  std::map<std::string, Json> ranges;        // what each method takes, without repetition
  std::map<std::string, std::string> texts;  // who takes it
  for (const Method& method : methods()) {
    for (const ParameterSpec& spec : method.parameters) {
      const Json schema = spec_schema(spec, limits);
      Json& known = ranges.emplace(spec.name, Json::array()).first->second;
      if (std::ranges::find(known, schema) == known.end()) known.push_back(schema);
      std::string& text = texts[spec.name];
      if (text.empty()) text = spec.text + " Of";
      text += ' ' + method.name;
    }
  }
  Json schemas = Json::object();
  for (auto& [name, known] : ranges) {
    schemas[name] = known.size() == 1 ? known[0] : Json{{"anyOf", known}};
    schemas[name]["description"] = texts[name] + '.';
  }
  return schemas;
}

}  // namespace burnish
