// Pixels, and the PNG file that they become.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/run/error.h"

namespace burnish::render {

/// As screens take it (sRGB), red first, 0 to 255.
using Color = std::array<std::uint8_t, 3>;

/// "#f4f5f7" or "f4f5f7". Errors: BadOption.
Result<Color> parse_color(std::string_view text);

/// Light itself, which adds up; colours do not.
struct Light {
  float red = 0, green = 0, blue = 0;

  Light& operator+=(const Light& b) { return red += b.red, green += b.green, blue += b.blue, *this; }
  friend Light operator+(Light a, const Light& b) { return a += b; }
  friend Light operator*(const Light& a, float s) { return {a.red * s, a.green * s, a.blue * s}; }
  friend Light operator*(const Light& a, const Light& b) {
    return {a.red * b.red, a.green * b.green, a.blue * b.blue};
  }
};
Light to_light(const Color& color);
Color to_color(const Light& light);  ///< clamped

struct Picture {
  Picture(unsigned columns, unsigned rows, const Color& background)
      : width(columns), height(rows), pixels(std::size_t{columns} * rows, background) {}

  Color& at(unsigned x, unsigned y) { return pixels[std::size_t{y} * width + x]; }
  const Color& at(unsigned x, unsigned y) const { return pixels[std::size_t{y} * width + x]; }

  unsigned width, height;
  std::vector<Color> pixels;  ///< from the top left, row by row
};

/// Errors: Internal.
Result<std::string> to_png(const Picture& picture);

}  // namespace burnish::render
