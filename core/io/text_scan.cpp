#include "core/io/text_scan.h"

#include <fast_float/fast_float.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/io/plain_number.h"

namespace burnish {
namespace {

constexpr std::ptrdiff_t kReach = kPlainNumberReach;
constexpr std::size_t kMostQuoted = 32;

}  // namespace

std::uint64_t line_at(std::string_view text, std::uint64_t offset) {
  std::uint64_t line = 1;
  for (std::uint64_t i = 0; i < offset && i < text.size(); ++i) {
    const bool lone_return = text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n');
    line += text[i] == '\n' || lone_return;
  }
  return line;
}

std::string line_place(std::string_view text, std::uint64_t offset) {
  return " (line " + std::to_string(line_at(text, offset)) + ')';
}

bool TextScanner::find_word() {
  for (; at_ != end_; ++at_) {
    if (comments_ && *at_ == '#') {
      skip_line();
      if (at_ == end_) return false;
    } else if (!is_blank(*at_) && !is_line_end(*at_)) {
      return true;
    }
  }
  return false;
}

bool TextScanner::find_word_of_line() {
  while (at_ != end_ && is_blank(*at_)) ++at_;
  return !ends_word(at_);
}

std::string_view TextScanner::word() {
  const char* const begin = at_;
  while (!ends_word(at_)) ++at_;
  return {begin, static_cast<std::size_t>(at_ - begin)};
}

void TextScanner::skip_line() {
  while (at_ != end_ && !is_line_end(*at_)) ++at_;
}

bool TextScanner::number(double& value) {
  const char* stop = at_;
  if (end_ - at_ > kReach && read_plain_decimal(stop, value) && ends_word(stop)) {
    at_ = stop;
    return true;
  }
  const char* const begin = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
  const auto [end, failure] = fast_float::from_chars(begin, end_, value);
  if (failure != std::errc() || !ends_word(end)) return false;
  at_ = end;
  return true;
}

bool TextScanner::integer(std::int64_t& value) {
  const char* stop = at_;
  if (std::uint32_t plain = 0; end_ - at_ > kReach && read_plain_integer(stop, plain) && ends_word(stop)) {
    value = plain;
    at_ = stop;
    return true;
  }
  const char* const begin = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
  const auto [end, failure] = std::from_chars(begin, end_, value);
  if (failure != std::errc() || !ends_word(end)) return false;
  at_ = end;
  return true;
}

bool TextScanner::coordinate(double& value) {
  if (!find_word()) return false;
  const char* const begin = at_;
  if (number(value) && std::abs(value) <= kLargestCoordinate) return true;
  at_ = begin;
  return false;
}

Error TextScanner::coordinate_error(const std::string& name, std::size_t axis) const {
  const std::string what = name + ": coordinate " + "xyz"[axis] + " is ";
  TextScanner copy = *this;
  double value = 0;
  if (!copy.number(value)) return fail(Cause::MalformedMesh, what + "not a number but " + quoted());
  return fail(Cause::NonFinitePosition,
              what + quoted() + (std::isfinite(value) ? ", beyond 1e60" : ", not a finite number"));
}

std::string TextScanner::quoted() const {
  const char* stop = at_;
  while (!ends_word(stop) && stop - at_ < std::ptrdiff_t{kMostQuoted}) ++stop;
  if (stop == at_) return at_ == end_ ? "the end of the file" : "the end of the line";
  std::string text = "\"";
  for (const char* p = at_; p != stop; ++p) text += *p >= 32 && *p < 127 ? *p : '?';
  return text + '"';
}

Result<> check_line_lengths(std::string_view text, std::uint64_t begin, const Limits& limits) {
  const std::uint64_t most = limits.max_line_bytes;
  while (text.size() - begin > most) {
    // Looking back from the limit finds an end in most files at once.
    const std::size_t end = text.substr(begin, most + 1).find_last_of("\r\n");
    if (end == std::string_view::npos) {
      return Error{Cause::TooLarge, "a line has more than " + std::to_string(most) +
                                        " bytes (max-line-bytes)" + line_place(text, begin)};
    }
    begin += end + 1;
  }
  return {};
}

}  // namespace burnish
