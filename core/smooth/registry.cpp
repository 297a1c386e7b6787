#include "core/smooth/registry.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/smooth/adaptive.h"
#include "core/smooth/auto.h"
#include "core/smooth/bilaplacian.h"
#include "core/smooth/bilateral.h"
#include "core/smooth/bilateral_normals.h"
#include "core/smooth/fast_effective.h"
#include "core/smooth/guided.h"
#include "core/smooth/hc_laplacian.h"
#include "core/smooth/implicit_mean_curvature_flow.h"
#include "core/smooth/joint_bilateral.h"
#include "core/smooth/laplacian.h"
#include "core/smooth/learned_normals.h"
#include "core/smooth/mean_curvature_flow.h"
#include "core/smooth/mean_normals.h"
#include "core/smooth/median_normals.h"
#include "core/smooth/ohtake.h"
#include "core/smooth/robust_normals.h"
#include "core/smooth/taubin.h"
#include "core/smooth/weighted_least_squares.h"
#include "core/smooth/windowed_sinc.h"

namespace burnish {
namespace {

template <class Items, class Name>
std::string list_names(const Items& items, Name&& name) {
  std::string list;
  for (const auto& item : items) list += (list.empty() ? "" : ", ") + name(item);
  return list;
}

/// As people write numbers: 0.5, 20, 100000, 1e+30.
std::string number_text(double value) {
  if (std::floor(value) == value && std::abs(value) < 1e7)
    return std::to_string(static_cast<std::int64_t>(value));
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

std::string value_text(const ParameterValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  return std::get<std::string>(value);
}

std::string range_text(const ParameterSpec& spec) {
  if (spec.kind == ParameterKind::Choice) return list_names(spec.choices, [](const auto& c) { return c; });
  return number_text(spec.minimum) + " to " + number_text(spec.maximum);
}

Error bad_value(const ParameterSpec& spec, const std::string& got) {
  const char* kind = spec.kind == ParameterKind::Choice    ? "one of "
                     : spec.kind == ParameterKind::Integer ? "a whole number from "
                                                           : "a number from ";
  return {Cause::BadOption, spec.name + " is " + got + "; it must be " + kind + range_text(spec), spec.name};
}

Result<const ParameterSpec*> find_parameter(const Method& method, std::string_view name) {
  for (const ParameterSpec& spec : method.parameters) {
    if (spec.name == name) return &spec;
  }
  return Error{Cause::UnknownOption,
               "method " + method.name + " has no parameter " + std::string(name) + "; it has " +
                   list_names(method.parameters, [](const auto& spec) { return spec.name; }),
               std::string(name)};
}

Result<ParameterValue> checked_value(const ParameterSpec& spec, const ParameterValue& value) {
  if (spec.kind == ParameterKind::Choice) {
    const auto* choice = std::get_if<std::string>(&value);
    if (choice && std::ranges::find(spec.choices, *choice) != spec.choices.end()) return value;
    return bad_value(spec, choice ? '"' + choice->substr(0, 64) + '"' : value_text(value));
  }
  if (const auto* text = std::get_if<std::string>(&value))
    return bad_value(spec, '"' + text->substr(0, 64) + '"');
  const auto* integer = std::get_if<std::int64_t>(&value);
  const double number = integer ? static_cast<double>(*integer) : std::get<double>(value);
  const bool in_range = number >= spec.minimum && number <= spec.maximum;  // false for NaN
  if (!in_range || (spec.kind == ParameterKind::Integer && std::floor(number) != number)) {
    return bad_value(spec, value_text(value));
  }
  if (spec.kind == ParameterKind::Integer) return ParameterValue(static_cast<std::int64_t>(number));
  return ParameterValue(number);
}

}  // namespace

std::span<const Method> methods() {
  static const std::vector<Method> kMethods = {
      auto_method(),
      adaptive_method(),
      laplacian_method(),
      taubin_method(),
      mean_curvature_flow_method(),
      implicit_mean_curvature_flow_method(),
      weighted_least_squares_method(),
      bilaplacian_method(),
      hc_laplacian_method(),
      windowed_sinc_method(),
      bilateral_method(),
      ohtake_method(),
      mean_normals_method(),
      median_normals_method(),
      fast_effective_method(),
      bilateral_normals_method(),
      joint_bilateral_method(),
      guided_method(),
      robust_normals_method(),
      learned_normals_method(),
  };
  return kMethods;
}

Result<const Method*> find_method(std::string_view name) {
  if (name.empty()) return &methods().front();
  for (const Method& method : methods()) {
    if (method.name == name) return &method;
  }
  return Error{Cause::UnknownMethod,
               "no method \"" + std::string(name.substr(0, 64)) + "\"; there are " +
                   list_names(methods(), [](const auto& method) { return method.name; }),
               "method"};
}

WorkMemory work_memory_of(std::string_view name) {
  if (const auto found = find_method(name)) return (*found)->work_memory;
  WorkMemory most;
  for (const Method& method : methods()) {
    most.per_vertex = std::max(most.per_vertex, method.work_memory.per_vertex);
    most.per_triangle = std::max(most.per_triangle, method.work_memory.per_triangle);
    most.per_triangle_of_part = std::max(most.per_triangle_of_part, method.work_memory.per_triangle_of_part);
  }
  return most;
}

double seconds_of(std::string_view name, std::uint64_t triangles, std::optional<double> iterations) {
  const auto method = find_method(name);
  if (!method) return 0;
  const auto& parameters = (*method)->parameters;
  const auto given = std::ranges::find(parameters, "iterations", &ParameterSpec::name);
  const double standard = static_cast<double>(std::get<std::int64_t>(given->default_value));
  return 1e-9 * (*method)->nanoseconds * static_cast<double>(triangles) * iterations.value_or(standard);
}

Result<ParameterValue> parse_parameter(const Method& method, std::string_view name, std::string_view text) {
  const auto spec = find_parameter(method, name);
  if (!spec) return spec.error();
  if ((*spec)->kind == ParameterKind::Choice) return checked_value(**spec, std::string(text));
  double number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || end != text.data() + text.size()) {
    return bad_value(**spec, '"' + std::string(text.substr(0, 64)) + '"');
  }
  return checked_value(**spec, number);
}

Result<ParameterValues> resolve_parameters(const Method& method,
                                           const std::map<std::string, ParameterValue>& given) {
  ParameterValues resolved;
  for (const ParameterSpec& spec : method.parameters) resolved.values[spec.name] = spec.default_value;
  for (const auto& [name, value] : given) {
    const auto spec = find_parameter(method, name);
    if (!spec) return spec.error();
    auto checked = checked_value(**spec, value);
    if (!checked) return checked.error();
    resolved.values[name] = std::move(*checked);
  }
  return resolved;
}

std::string methods_markdown() {
  std::string text;
  for (const Method& method : methods()) {
    text += "### `" + method.name + "`\n\n" + method.summary + "\n\n";
    text += "Reference: " + method.reference + ".\n\n    " + method.formula + "\n\n";
    text += "| parameter | default | range | unit | what it does |\n|---|---|---|---|---|\n";
    for (const ParameterSpec& spec : method.parameters) {
      text += "| `" + spec.name + "` | " + value_text(spec.default_value) + " | " + range_text(spec) + " | " +
              spec.unit + " | " + spec.text + " |\n";
    }
    text += '\n';
  }
  return text;
}

}  // namespace burnish
