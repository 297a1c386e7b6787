#include "client/render/picture.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace burnish::render {
namespace {

/// IEC 61966-2-1.
double linear(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

const std::array<float, 256>& linear_table() {
  static const auto kTable = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(linear(double(i) / 255));
    return table;
  }();
  return kTable;
}

/// The value whose light is nearest.
std::uint8_t to_value(float light) {
  const auto& table = linear_table();
  const auto above = std::lower_bound(table.begin(), table.end(), light);
  if (above == table.begin()) return 0;
  if (above == table.end()) return 255;
  const bool lower = light - *(above - 1) < *above - light;
  return static_cast<std::uint8_t>(above - table.begin() - (lower ? 1 : 0));
}

png_image header(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = picture.width;
  image.height = picture.height;
  image.format = PNG_FORMAT_RGB;
  return image;
}

}  // namespace

Result<Color> parse_color(std::string_view text) {
  const std::string_view digits = text.starts_with('#') ? text.substr(1) : text;
  Color color{};
  bool fine = digits.size() == 6;
  for (std::size_t i = 0; fine && i < 6; ++i) {
    const char c = digits[i];
    const bool decimal = c >= '0' && c <= '9', lower = c >= 'a' && c <= 'f', upper = c >= 'A' && c <= 'F';
    fine = decimal || lower || upper;
    const int value = decimal ? c - '0' : lower ? c - 'a' + 10 : c - 'A' + 10;
    color[i / 2] = static_cast<std::uint8_t>(16 * color[i / 2] + value);
  }
  if (fine) return color;
  return Error{Cause::BadOption, "'" + std::string(text) + "' is no colour; give it as #rrggbb"};
}

Light to_light(const Color& color) {
  const auto& table = linear_table();
  return {table[color[0]], table[color[1]], table[color[2]]};
}

Color to_color(const Light& light) {
  return {to_value(light.red), to_value(light.green), to_value(light.blue)};
}

Result<std::string> to_png(const Picture& picture) {
  png_image image = header(picture);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.pixels.data(), 0, nullptr) == 0) {
    return Error{Cause::Internal, "libpng: " + std::string(image.message)};
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace burnish::render
