// Words and numbers of text files whose lines mean little or nothing: PLY, OFF and STL.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/io/codec.h"
#include "core/io/text_range.h"

namespace burnish {

/// 1-based line of a place in a text.
std::uint64_t line_at(std::string_view text, std::uint64_t offset);

/// " (line 12)"
std::string line_place(std::string_view text, std::uint64_t offset);

/// Goes through a text word by word. Blanks and line ends separate words; with `comments`, so does what
/// stands from '#' to the end of its line.
class TextScanner {
 public:
  TextScanner(std::string_view text, std::uint64_t begin, bool comments)
      : text_(text), at_(text.data() + begin), end_(text.data() + text.size()), comments_(comments) {}

  std::uint64_t offset() const { return static_cast<std::uint64_t>(at_ - text_.data()); }

  /// Goes to the next word, over line ends; false at the end of the text.
  bool find_word();
  /// The same within the line; false at its end.
  bool find_word_of_line();
  /// Passes the word that begins here; empty when none does.
  std::string_view word();
  /// Goes to the line's end, or the text's.
  void skip_line();

  /// Passes the number that begins here; false, and nothing has happened, when the word is none. NaN and
  /// infinity are numbers.
  bool number(double& value);
  /// The same for whole numbers of 64 bits.
  bool integer(std::int64_t& value);
  /// Goes to the next word and passes it, a number that may be a coordinate; false: see coordinate_error().
  bool coordinate(double& value);
  /// Why the word here is no coordinate of what `name` names ("vertex 7"). MalformedMesh, NonFinitePosition.
  Error coordinate_error(const std::string& name, std::size_t axis) const;

  /// What stands here as a message quotes it: `"1.2x"`, "the end of the line" or "the end of the file".
  std::string quoted() const;
  Error fail(Cause cause, const std::string& message) const {
    return {cause, message + line_place(text_, offset())};
  }

 private:
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\f' || c == '\v'; }
  bool ends_word(const char* p) const {
    return p == end_ || is_blank(*p) || is_line_end(*p) || (comments_ && *p == '#');
  }

  std::string_view text_;
  const char* at_;
  const char* const end_;
  const bool comments_;
};

/// That no line from `begin` on is longer than the limit. Errors: TooLarge, which names the line.
Result<> check_line_lengths(std::string_view text, std::uint64_t begin, const Limits& limits);

/// Copies a stretch of a text, replacing stretches of it in ascending order.
class Patcher {
 public:
  Patcher(std::string_view text, std::uint64_t begin, std::uint64_t end)
      : text_(text), copied_(begin), end_(end) {
    out_.reserve((end - begin) + (end - begin) / 2 + 64);  // what nobody writes to costs nothing
  }

  /// Where the replacement for `range` is to be appended.
  std::string& replace(const TextRange& range) {
    out_.append(text_, copied_, range.begin - copied_);
    copied_ = range.begin + range.length;
    return out_;
  }

  std::string finish() && {
    out_.append(text_, copied_, end_ - copied_);
    return std::move(out_);
  }

 private:
  std::string_view text_;
  std::string out_;
  std::uint64_t copied_, end_;
};

}  // namespace burnish
