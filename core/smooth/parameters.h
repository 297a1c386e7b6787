// Short ways to write parameter specs in a method's file.
#pragma once

#include "core/smooth/iteration.h"

namespace burnish {

inline ParameterSpec number_parameter(std::string name, double value, double minimum, double maximum,
                                      std::string unit, std::string text) {
  return {.name = std::move(name),
          .default_value = value,
          .minimum = minimum,
          .maximum = maximum,
          .unit = std::move(unit),
          .text = std::move(text)};
}

inline ParameterSpec count_parameter(std::string name, std::uint32_t value, double minimum, double maximum,
                                     std::string text) {
  return {.name = std::move(name),
          .kind = ParameterKind::Integer,
          .default_value = std::int64_t{value},
          .minimum = minimum,
          .maximum = maximum,
          .unit = "1",
          .text = std::move(text)};
}

/// The first choice is the default.
inline ParameterSpec choice_parameter(std::string name, std::vector<std::string> choices, std::string text) {
  ParameterSpec spec{.name = std::move(name), .kind = ParameterKind::Choice, .text = std::move(text)};
  spec.default_value = choices.front();
  spec.choices = std::move(choices);
  return spec;
}

/// A method's own parameters, followed by those of every iterative method, with its default of `iterations`.
inline std::vector<ParameterSpec> with_iteration_parameters(
    std::vector<ParameterSpec> own, std::uint32_t iterations = IterationOptions{}.iterations) {
  for (ParameterSpec& spec : iteration_parameters()) {
    if (spec.name == "iterations") spec.default_value = std::int64_t{iterations};
    own.push_back(std::move(spec));
  }
  return own;
}

}  // namespace burnish
