#include "tests/bench/denoise_sweep.h"

#include <cstdio>

namespace burnish::bench {
namespace {

/// One parameter and the values to try.
struct Axis {
  const char* parameter;
  std::vector<ParameterValue> values;
};

Axis numbers(const char* parameter, std::initializer_list<double> values) {
  return {parameter, {values.begin(), values.end()}};
}
Axis choices(const char* parameter, std::initializer_list<const char*> values) {
  Axis axis{parameter, {}};
  for (const char* value : values) axis.values.emplace_back(std::string(value));
  return axis;
}
Axis neighbourhoods() { return choices("neighbourhood", {"edges", "vertices"}); }

/// Several grids for methods that are several methods.
const std::multimap<std::string_view, std::vector<Axis>>& grids() {
  static const std::multimap<std::string_view, std::vector<Axis>> kGrids = {
      {"adaptive",
       {numbers("iterations", {3, 5, 10, 20, 40, 80}), choices("normals", {"raw", "unit"}),
        neighbourhoods()}},
      {"laplacian", {numbers("iterations", {1, 2, 3, 5, 8, 12, 20}), numbers("lambda", {0.2, 0.5})}},
      {"taubin", {numbers("iterations", {3, 6, 12, 25, 50, 100}), numbers("mu", {-0.51, -0.53, -0.56})}},
      {"mean_curvature_flow",
       {numbers("iterations", {3, 6, 12, 25, 50}), numbers("time_step", {0.01, 0.025, 0.06})}},
      {"implicit_mean_curvature_flow",
       {numbers("iterations", {1, 3}), numbers("time_step", {0.03, 0.06, 0.12, 0.25, 0.5})}},
      {"weighted_least_squares",
       {numbers("iterations", {2, 5, 10}), numbers("lambda", {0.05, 0.15, 0.5}),
        numbers("sigma", {0.3, 0.6, 1})}},
      {"bilaplacian", {numbers("iterations", {3, 6, 12, 25, 50, 100})}},
      {"hc_laplacian", {numbers("iterations", {3, 6, 12, 25, 50}), numbers("beta", {0.5, 0.6, 0.7})}},
      {"windowed_sinc", {numbers("iterations", {15, 40}), numbers("pass_band", {0.03, 0.06, 0.1, 0.2, 0.4})}},
      {"bilateral",
       {numbers("iterations", {2, 4, 8, 16}), numbers("sigma_c", {0.7, 1.2}),
        numbers("sigma_s", {0, 0.2, 0.4, 0.8})}},
      {"ohtake",
       {numbers("iterations", {10, 20, 40, 80}), numbers("curvature", {0.3, 0.6, 1.2}), neighbourhoods()}},
      {"mean_normals", {numbers("iterations", {3, 6, 12, 25, 50}), neighbourhoods()}},
      {"median_normals", {numbers("iterations", {5, 10, 20, 40, 80})}},
      {"fast_effective",
       {numbers("iterations", {5, 10, 20, 40}), numbers("normal_steps", {2, 5}),
        numbers("threshold", {0.2, 0.4, 0.6, 0.8})}},
      {"bilateral_normals",
       {choices("scheme", {"local"}), numbers("iterations", {5, 10, 20, 40}),
        numbers("sigma_s", {0.25, 0.35, 0.45, 0.6}), numbers("vertex_steps", {2, 10})}},
      {"bilateral_normals",
       {choices("scheme", {"global"}), numbers("iterations", {1, 3}), numbers("sigma_s", {0.3, 0.5}),
        numbers("lambda", {0.003, 0.03}), numbers("vertex_steps", {20})}},
      {"joint_bilateral",
       {numbers("iterations", {10, 20, 40}), numbers("sigma_s", {0.1, 0.2, 0.35}),
        numbers("guide_steps", {1, 3}), numbers("vertex_steps", {2, 10})}},
      {"guided",
       {numbers("iterations", {5, 10, 20, 40, 75}), numbers("sigma_r", {0.2, 0.28, 0.35, 0.45, 0.6}),
        numbers("vertex_steps", {10})}},
      {"robust_normals",
       {numbers("iterations", {5, 10, 20, 40}), numbers("first_threshold", {0.9, 1.4}),
        numbers("second_threshold", {0.35, 0.5, 0.7}), numbers("vertex_steps", {4})}},
      {"l0", {numbers("lambda", {0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8}), numbers("alpha", {0, 0.1})}},
      {"l0", {numbers("lambda", {0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8}), numbers("mu", {1.19})}},
  };
  return kGrids;
}

void add_combinations(const std::vector<Axis>& axes, std::vector<Settings>& all) {
  std::vector<Settings> partial = {{}};
  for (const Axis& axis : axes) {
    std::vector<Settings> longer;
    for (const Settings& settings : partial) {
      for (const ParameterValue& value : axis.values) {
        longer.push_back(settings);
        longer.back()[axis.parameter] = value;
      }
    }
    partial = std::move(longer);
  }
  all.insert(all.end(), partial.begin(), partial.end());
}

}  // namespace

std::vector<Settings> sweep_of(std::string_view method) {
  std::vector<Settings> all = {{}};
  const auto [from, to] = grids().equal_range(method);
  for (auto grid = from; grid != to; ++grid) add_combinations(grid->second, all);
  return all;
}

std::string text_of(const Settings& settings) {
  std::string text;
  for (const auto& [name, value] : settings) {
    text += (text.empty() ? "" : " ") + name + "=";
    if (const auto* choice = std::get_if<std::string>(&value)) {
      text += *choice;
    } else {
      char number[32];
      std::snprintf(number, sizeof number, "%g", std::get<double>(value));
      text += number;
    }
  }
  return text.empty() ? "defaults" : text;
}

}  // namespace burnish::bench
