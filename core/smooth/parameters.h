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

/// The first choice is the default.
inline ParameterSpec choice_parameter(std::string name, std::vector<std::string> choices, std::string text) {
  ParameterSpec spec{.name = std::move(name), .kind = ParameterKind::Choice, .text = std::move(text)};
  spec.default_value = choices.front();
  spec.choices = std::move(choices);
  return spec;
}

/// A method's own parameters, followed by those of every iterative method.
inline std::vector<ParameterSpec> with_iteration_parameters(std::vector<ParameterSpec> own) {
  for (ParameterSpec& spec : iteration_parameters()) own.push_back(std::move(spec));
  return own;
}

}  // namespace burnish
