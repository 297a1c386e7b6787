# The font's file as an array: -DFONT=file.ttf -DOUT=font.cpp
file(READ "${FONT}" bytes HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
file(WRITE "${OUT}" "#include <span>\n\nnamespace burnish::render {\nnamespace {\n"
  "constexpr unsigned char kFont[] = {${bytes}};\n}\n"
  "std::span<const unsigned char> font_file();\n"
  "std::span<const unsigned char> font_file() { return kFont; }\n}\n")
