#include "client/cli/smooth_arguments.h"

#include <charconv>
#include <cmath>

#include "client/cli/mesh_files.h"
#include "server/service/smooth_service.h"

namespace burnish::cli {
namespace {

/// A number where the text is one, else a choice's name: the server that runs the method knows which it
/// wants.
google::protobuf::Value value_of(const std::string& text) {
  google::protobuf::Value value;
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, problem] = std::from_chars(text.data(), end, number);
  if (problem == std::errc{} && stop == end && std::isfinite(number)) {
    value.set_number_value(number);
  } else {
    value.set_string_value(text);
  }
  return value;
}

Result<> set_parameters(v1::SmoothOptions& options, const std::vector<std::string>& assignments) {
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    if (equals == 0 || equals == std::string::npos) {
      return Error{Cause::BadOption, "--set takes name=value, not '" + assignment + "'", "set"};
    }
    const std::string name = assignment.substr(0, equals);
    if (!options.mutable_parameters()->insert({name, value_of(assignment.substr(equals + 1))}).second) {
      return Error{Cause::BadOption, "'" + name + "' is set twice", name};
    }
  }
  return {};
}

v1::PinnedVertices pinned(const SmoothArguments& arguments) {
  v1::PinnedVertices pinned;
  pinned.mutable_vertices()->Assign(arguments.pinned_vertices.begin(), arguments.pinned_vertices.end());
  pinned.set_group(arguments.pinned_group);
  pinned.set_attribute(arguments.pinned_attribute);
  return pinned;
}

v1::OutputOptions output_options(const SmoothArguments& arguments, const std::string& out) {
  v1::OutputOptions output;
  const std::optional<Format> by_name = format_of_name(out);
  output.set_format(
      arguments.output_format.value_or(by_name ? to_proto(*by_name) : v1::MESH_FORMAT_UNSPECIFIED));
  v1::DracoOptions draco;
  draco.set_method(arguments.draco_method);
  if (arguments.position_bits) draco.set_position_bits(*arguments.position_bits);
  if (arguments.normal_bits) draco.set_normal_bits(*arguments.normal_bits);
  if (arguments.texture_coordinate_bits)
    draco.set_texture_coordinate_bits(*arguments.texture_coordinate_bits);
  if (arguments.color_bits) draco.set_color_bits(*arguments.color_bits);
  if (arguments.generic_bits) draco.set_generic_bits(*arguments.generic_bits);
  if (arguments.speed) draco.set_speed(*arguments.speed);
  if (draco.ByteSizeLong() > 0) *output.mutable_draco() = draco;
  return output;
}

}  // namespace

Result<v1::SmoothOptions> smooth_options(const SmoothArguments& arguments, const std::string& out) {
  v1::SmoothOptions options;
  options.set_method(arguments.method);
  if (arguments.iterations) options.set_iterations(*arguments.iterations);
  if (Result<> set = set_parameters(options, arguments.assignments); !set) return set.error();
  if (const auto pins = pinned(arguments); pins.ByteSizeLong() > 0) *options.mutable_pinned() = pins;
  *options.mutable_output() = output_options(arguments, out);
  return options;
}

}  // namespace burnish::cli
