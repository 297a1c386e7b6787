#include "client/render/text.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace burnish::render {

std::span<const unsigned char> font_file();  // made by CMake from Debian's file

/// FreeType's handles.
struct Text::Library {
  Library() = default;
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  FT_Library library = nullptr;
  FT_Face face = nullptr;
};

namespace {

constexpr char32_t kUnknown = U'?';

/// The code points of UTF-8 text.
std::vector<char32_t> letters(std::string_view text) {
  std::vector<char32_t> result;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i++]);
    const int more = first < 0x80                    ? 0
                     : first >= 0xF0 && first < 0xF8 ? 3
                     : first >= 0xE0 && first < 0xF0 ? 2
                     : first >= 0xC2 && first < 0xE0 ? 1
                                                     : -1;
    char32_t letter = more <= 0 ? first : first & (0x3FU >> more);
    bool fine = more >= 0;
    for (int n = 0; fine && n < more; ++n) {
      fine = i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80;
      if (fine) letter = letter << 6 | (static_cast<unsigned char>(text[i++]) & 0x3FU);
    }
    result.push_back(fine && letter >= U' ' ? letter : kUnknown);
  }
  return result;
}

/// Outlines as they are drawn: hints for small sizes would differ between versions of the library.
constexpr FT_Int32 kLoad = FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP | FT_LOAD_RENDER;

bool load(FT_Face face, char32_t letter, FT_Int32 flags) { return FT_Load_Char(face, letter, flags) == 0; }

Color blend(const Color& below, const Color& above, unsigned cover) {
  Color color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = static_cast<std::uint8_t>((below[c] * (255 - cover) + above[c] * cover + 127) / 255);
  }
  return color;
}

void stamp(Picture& picture, const FT_Bitmap& bitmap, int left, int top, const Color& color) {
  for (unsigned row = 0; row < bitmap.rows; ++row) {
    for (unsigned column = 0; column < bitmap.width; ++column) {
      const int x = left + static_cast<int>(column), y = top + static_cast<int>(row);
      if (x < 0 || y < 0 || x >= static_cast<int>(picture.width) || y >= static_cast<int>(picture.height)) {
        continue;
      }
      Color& pixel = picture.at(static_cast<unsigned>(x), static_cast<unsigned>(y));
      pixel = blend(pixel, color, bitmap.buffer[row * static_cast<unsigned>(bitmap.pitch) + column]);
    }
  }
}

}  // namespace

Result<Text> Text::of_size(unsigned size) {
  const auto library = std::make_shared<Library>();
  const auto file = font_file();
  if (FT_Init_FreeType(&library->library) != 0 ||
      FT_New_Memory_Face(library->library, file.data(), static_cast<FT_Long>(file.size()), 0,
                         &library->face) != 0 ||
      FT_Set_Pixel_Sizes(library->face, 0, size) != 0) {
    return Error{Cause::Internal, "FreeType cannot open the font"};
  }
  Text text;
  text.library_ = library;
  return text;
}

unsigned Text::ascent() const { return static_cast<unsigned>(library_->face->size->metrics.ascender >> 6); }
unsigned Text::descent() const {
  return static_cast<unsigned>(-library_->face->size->metrics.descender >> 6);
}

unsigned Text::width(std::string_view text) const {
  FT_Pos sum = 0;
  for (const char32_t letter : letters(text)) {
    if (load(library_->face, letter, kLoad)) sum += library_->face->glyph->advance.x;
  }
  return static_cast<unsigned>((sum + 63) >> 6);
}

void Text::draw(Picture& picture, int left, int base, std::string_view text, const Color& color) const {
  FT_Pos pen = FT_Pos{left} << 6;
  for (const char32_t letter : letters(text)) {
    if (!load(library_->face, letter, kLoad)) continue;
    const FT_GlyphSlot glyph = library_->face->glyph;
    stamp(picture, glyph->bitmap, static_cast<int>(pen >> 6) + glyph->bitmap_left, base - glyph->bitmap_top,
          color);
    pen += glyph->advance.x;
  }
}

void Text::draw_centred(Picture& picture, int centre, int base, std::string_view text,
                        const Color& color) const {
  draw(picture, centre - static_cast<int>(width(text)) / 2, base, text, color);
}

}  // namespace burnish::render
