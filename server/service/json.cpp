#include <google/protobuf/util/json_util.h>

#include <map>
#include <nlohmann/json.hpp>

#include "server/service/options.h"
#include "server/service/smooth_service.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;

v1::ParameterKind to_proto(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::Number:
      return v1::PARAMETER_KIND_NUMBER;
    case ParameterKind::Integer:
      return v1::PARAMETER_KIND_INTEGER;
    case ParameterKind::Choice:
      return v1::PARAMETER_KIND_CHOICE;
  }
  return v1::PARAMETER_KIND_UNSPECIFIED;
}

void describe(const ParameterSpec& spec, v1::ParameterDescription& out) {
  out.set_name(spec.name);
  out.set_kind(to_proto(spec.kind));
  *out.mutable_default_value() = burnish::to_proto(spec.default_value);
  out.set_minimum(spec.minimum);
  out.set_maximum(spec.maximum);
  for (const std::string& choice : spec.choices) out.add_choices(choice);
  out.set_unit(spec.unit);
  out.set_description(spec.text);
}

/// A report's parameters are a protobuf map, whose order changes from run to run.
void sort_parameters(Json& json) {
  const auto parameters = json.find("parameters");
  if (parameters == json.end() || !parameters->is_object()) return;
  std::map<std::string, Json> sorted;
  for (const auto& [name, value] : parameters->items()) sorted.emplace(name, value);
  *parameters = Json(sorted);
}

}  // namespace

v1::ListMethodsResponse list_methods() {
  v1::ListMethodsResponse response;
  for (const Method& method : methods()) {
    v1::MethodDescription& description = *response.add_methods();
    description.set_name(method.name);
    description.set_summary(method.summary);
    description.set_reference(method.reference);
    for (const ParameterSpec& spec : method.parameters) describe(spec, *description.add_parameters());
  }
  return response;
}

std::string to_json(const google::protobuf::Message& message, bool compact) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  std::string text;
  // Fails only for messages that JSON cannot express (bad UTF-8, non-finite Values); ours never hold any.
  if (!google::protobuf::util::MessageToJsonString(message, &text, options).ok()) return "{}";
  Json json = Json::parse(text);
  sort_parameters(json);
  if (const auto choice = json.find("choice"); choice != json.end() && choice->is_object())
    sort_parameters(*choice);
  return json.dump(compact ? -1 : 2);
}

}  // namespace burnish
