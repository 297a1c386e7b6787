#include "server/service/options.h"
#include "server/service/smooth_service.h"

namespace burnish {
namespace {

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

}  // namespace burnish
