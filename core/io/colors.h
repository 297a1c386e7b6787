// Colours as other formats write them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace burnish {

/// True when bytes lose nothing of colours in [0, 1].
inline bool are_whole_bytes(std::span<const float> colors) {
  return std::ranges::all_of(colors, [](float c) {
    const float scaled = c * 255.0f;
    return scaled >= 0 && scaled <= 255 && std::abs(scaled - std::round(scaled)) <= 1e-4f;
  });
}

inline std::uint8_t whole_byte(float color) { return static_cast<std::uint8_t>(std::lround(color * 255.0f)); }

}  // namespace burnish
