#include "client/render/color_map.h"

#include <algorithm>
#include <cmath>

namespace burnish::render {

Color heat_color(double share) {
  constexpr std::array<Color, 5> kStops = {
      {{236, 238, 237}, {251, 208, 124}, {240, 128, 62}, {188, 42, 74}, {72, 12, 74}}};
  const double place = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto stop = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  const double part = place - static_cast<double>(stop);
  Color color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] =
        static_cast<std::uint8_t>(std::lround(kStops[stop][c] * (1 - part) + kStops[stop + 1][c] * part));
  }
  return color;
}

double round_up(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 0;
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (value <= step * power * (1 + 1e-12)) return step * power;
  }
  return 10 * power;
}

}  // namespace burnish::render
