// Private to the OBJ codec: goes through a text that the parser has accepted, for what only few ask.
#pragma once

#include <string_view>

namespace burnish {

/// Goes from statement to statement exactly as the parser did: the faces that both count must be the same.
class ObjStatements {
 public:
  explicit ObjStatements(std::string_view text) : at_(text.data()), end_(at_ + text.size()) {}

  bool at_end() const { return at_ == end_; }
  const char* at() const { return at_; }
  void go_back_to(const char* at) { at_ = at; }

  /// The next statement's keyword; the cursor stands behind it, of a vn statement behind its numbers.
  std::string_view keyword() {
    skip_blanks();
    const std::string_view keyword = word([](char) { return false; });
    if (keyword == "vn") skip_normal();
    return keyword;
  }

  /// The next word of the statement; empty at its end.
  std::string_view name() {
    skip_blanks();
    return word([this](char) { return hidden_line_end() > 0; });
  }

  void skip_line() {
    while (at_ != end_ && !is_line_end(*at_)) ++at_;
    if (at_ != end_) ++at_;
  }

 private:
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }

  /// Up to a blank, a line end, or where `ends` says so.
  template <class Ends>
  std::string_view word(Ends&& ends) {
    const char* const begin = at_;
    while (at_ != end_ && !is_blank(*at_) && !is_line_end(*at_) && !ends(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  /// Three words, wherever they stand: unlike the numbers of other statements behind a backslash, they may
  /// look like a statement.
  void skip_normal() {
    for (int axis = 0; axis < 3; ++axis) {
      skip_blanks();
      word([this](char c) { return c == '#' || hidden_line_end() > 0; });
    }
  }

  void skip_blanks() {
    while (at_ != end_) {
      const std::size_t length = is_blank(*at_) ? 1 : hidden_line_end();
      if (length == 0) return;
      at_ += length;
    }
  }

  /// Length of a line end behind a backslash; 0 when there is none here.
  std::size_t hidden_line_end() const {
    if (*at_ != '\\' || at_ + 1 == end_ || !is_line_end(at_[1])) return 0;
    return at_[1] == '\r' && at_ + 2 != end_ && at_[2] == '\n' ? 3 : 2;
  }

  const char* at_;
  const char* const end_;
};

}  // namespace burnish
