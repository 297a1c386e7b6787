// PNG files back into pixels.
#pragma once

#include <gtest/gtest.h>
#include <png.h>

#include <string>

#include "client/render/picture.h"

namespace burnish::render {

inline Picture from_png(const std::string& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0) << image.message;
  image.format = PNG_FORMAT_RGB;
  Picture picture(image.width, image.height, {});
  EXPECT_NE(png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr), 0) << image.message;
  return picture;
}

}  // namespace burnish::render
