// Words in pictures, in Open Sans, which is part of the program.
#pragma once

#include <memory>
#include <string_view>

#include "client/render/picture.h"

namespace burnish::render {

/// One font in one size. Not thread-safe.
class Text {
 public:
  /// `size`: pixels from line to line, roughly. Errors: Internal.
  static Result<Text> of_size(unsigned size);

  /// Pixels that the text takes; UTF-8, what is none shows as a question mark.
  unsigned width(std::string_view text) const;
  /// Pixels above and below the line that letters stand on.
  unsigned ascent() const;
  unsigned descent() const;

  /// Draws from `left`, standing on the line `base`; what lies outside of the picture is left out.
  void draw(Picture& picture, int left, int base, std::string_view text, const Color& color) const;
  void draw_centred(Picture& picture, int centre, int base, std::string_view text, const Color& color) const;

 private:
  struct Library;
  std::shared_ptr<const Library> library_;
};

}  // namespace burnish::render
