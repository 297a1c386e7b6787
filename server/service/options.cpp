#include "server/service/options.h"

#include "server/service/smooth_service.h"

namespace burnish {
namespace {

using google::protobuf::Value;

Result<ParameterValue> from_proto(const std::string& name, const Value& value) {
  switch (value.kind_case()) {
    case Value::kNumberValue:
      return ParameterValue(value.number_value());
    case Value::kStringValue:
      return ParameterValue(value.string_value());
    default:
      return Error{Cause::BadOption, name + " must be a number or a string", name};
  }
}

Result<std::map<std::string, ParameterValue>> given_parameters(const v1::SmoothOptions& options) {
  std::map<std::string, ParameterValue> given;
  for (const auto& [name, value] : options.parameters()) {
    auto converted = from_proto(name, value);
    if (!converted) return converted.error();
    given.emplace(name, std::move(*converted));
  }
  if (options.has_iterations() && !given.emplace("iterations", std::int64_t{options.iterations()}).second) {
    return Error{Cause::BadOption, "iterations is given twice: as an option and as a parameter",
                 "iterations"};
  }
  return given;
}

/// Reads one optional field of DracoOptions into `target`.
Result<> read_bits(bool given, std::uint32_t value, std::uint32_t least, std::uint32_t most,
                   bool zero_allowed, const char* name, std::optional<int>& target) {
  if (!given) return {};
  if (value > most || (value < least && !(value == 0 && zero_allowed))) {
    return Error{Cause::BadOption,
                 std::string(name) + " is " + std::to_string(value) + "; it must be " +
                     (zero_allowed && least > 0 ? "0 (lossless) or " : "") + std::to_string(least) + " to " +
                     std::to_string(most),
                 std::string("output.draco.") + name};
  }
  target = static_cast<int>(value);
  return {};
}

Result<DracoOptions> resolve_draco(const v1::DracoOptions& given) {
  DracoOptions options;
  switch (given.method()) {
    case v1::DRACO_METHOD_UNSPECIFIED:
      break;
    case v1::DRACO_METHOD_SEQUENTIAL:
      options.method = DracoMethod::Sequential;
      break;
    case v1::DRACO_METHOD_EDGEBREAKER:
      options.method = DracoMethod::Edgebreaker;
      break;
    default:
      return Error{Cause::BadOption, "output.draco.method is not a known method", "output.draco.method"};
  }
  struct Field {
    bool given;
    std::uint32_t value, least, most;
    bool zero_allowed;
    const char* name;
    std::optional<int>& target;
  };
  const Field fields[] = {
      {given.has_position_bits(), given.position_bits(), 1, 30, true, "position_bits", options.position_bits},
      {given.has_normal_bits(), given.normal_bits(), 2, 30, true, "normal_bits", options.normal_bits},
      {given.has_texture_coordinate_bits(), given.texture_coordinate_bits(), 1, 30, true,
       "texture_coordinate_bits", options.texture_coordinate_bits},
      {given.has_color_bits(), given.color_bits(), 1, 30, true, "color_bits", options.color_bits},
      {given.has_generic_bits(), given.generic_bits(), 1, 30, true, "generic_bits", options.generic_bits},
      {given.has_speed(), given.speed(), 0, 10, false, "speed", options.speed},
  };
  for (const Field& f : fields) {
    if (auto r = read_bits(f.given, f.value, f.least, f.most, f.zero_allowed, f.name, f.target); !r)
      return r.error();
  }
  return options;
}

PinOptions resolve_pins(const v1::PinnedVertices& given) {
  return {.vertices = {given.vertices().begin(), given.vertices().end()},
          .group = given.group(),
          .attribute = given.attribute()};
}

}  // namespace

Result<ResolvedOptions> resolve_options(const v1::SmoothOptions& options) {
  ResolvedOptions resolved;
  const auto method = find_method(options.method());
  if (!method) return method.error();
  resolved.method = *method;
  auto given = given_parameters(options);
  if (!given) return given.error();
  auto parameters = resolve_parameters(**method, *given);
  if (!parameters) return parameters.error();
  resolved.parameters = std::move(*parameters);
  if (!v1::MeshFormat_IsValid(options.output().format())) {
    return Error{Cause::BadOption, "output.format is not a known format", "output.format"};
  }
  resolved.output.format = from_proto(options.output().format());
  auto draco = resolve_draco(options.output().draco());
  if (!draco) return draco.error();
  resolved.output.draco = *draco;
  resolved.pinned = resolve_pins(options.pinned());
  return resolved;
}

Value to_proto(const ParameterValue& value) {
  Value converted;
  if (const auto* text = std::get_if<std::string>(&value)) {
    converted.set_string_value(*text);
  } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    converted.set_number_value(static_cast<double>(*integer));
  } else {
    converted.set_number_value(std::get<double>(value));
  }
  return converted;
}

Result<> set_parameter_from_text(v1::SmoothOptions& options, std::string_view name, std::string_view text) {
  const auto method = find_method(options.method());
  if (!method) return method.error();
  auto value = parse_parameter(**method, name, text);
  if (!value) return value.error();
  if (name == "iterations") {
    options.set_iterations(static_cast<std::uint32_t>(std::get<std::int64_t>(*value)));
  } else {
    (*options.mutable_parameters())[std::string(name)] = to_proto(*value);
  }
  return {};
}

v1::MeshFormat to_proto(Format format) {
  switch (format) {
    case Format::Obj:
      return v1::MESH_FORMAT_OBJ;
    case Format::Draco:
      return v1::MESH_FORMAT_DRACO;
    case Format::Ply:
      return v1::MESH_FORMAT_PLY;
    case Format::Stl:
      return v1::MESH_FORMAT_STL;
    case Format::Off:
      return v1::MESH_FORMAT_OFF;
    case Format::Glb:
      return v1::MESH_FORMAT_GLB;
  }
  return v1::MESH_FORMAT_UNSPECIFIED;
}

std::optional<Format> from_proto(v1::MeshFormat format) {
  for (const FormatTraits& each : formats()) {
    if (to_proto(each.format) == format) return each.format;
  }
  return std::nullopt;
}

}  // namespace burnish
