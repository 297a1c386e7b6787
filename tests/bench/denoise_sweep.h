// What an expert with the truth in hand would try: a small grid for each method over the parameters that
// matter most.
#pragma once

#include <map>
#include <string_view>
#include <vector>

#include "core/smooth/registry.h"

namespace burnish::bench {

using Settings = std::map<std::string, ParameterValue>;

/// Every combination of the method's grid; only its defaults for a method without one.
std::vector<Settings> sweep_of(std::string_view method);

/// "sigma_r=0.35 iterations=20"
std::string text_of(const Settings& settings);

}  // namespace burnish::bench
