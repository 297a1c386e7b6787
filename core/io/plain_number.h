// Plain decimal text to numbers, eight digits at a time: what nearly every line of an OBJ file holds.
// Whatever is not plain is for the general reader (fast_float), which gives the same numbers.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace burnish {

/// Bytes behind a number's first character that the functions below may read.
inline constexpr std::size_t kPlainNumberReach = 64;

namespace detail {
static_assert(std::endian::native == std::endian::little, "the first character is the lowest byte");

inline constexpr std::uint64_t kEachByte = 0x0101010101010101U;

inline std::uint64_t eight_bytes(const char* p) {
  std::uint64_t bytes;
  std::memcpy(&bytes, p, sizeof bytes);
  return bytes;
}

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

/// How many of eight characters are digits before the first that is none.
inline unsigned leading_digits(std::uint64_t bytes) {
  const std::uint64_t values = bytes ^ kEachByte * '0';  // a digit: 0 to 9
  const std::uint64_t others = ((values + kEachByte * (127 - 9)) | values) & kEachByte * 128;
  return static_cast<unsigned>(std::countr_zero(others)) / 8;
}

/// The number that eight digits are, by pairs, fours and all.
inline std::uint64_t value_of_eight(std::uint64_t digits) {
  digits = (digits & kEachByte * 15) * (1 + (10 << 8)) >> 8;
  digits = (digits & 0x00FF00FF00FF00FFU) * (1 + (100 << 16)) >> 16;
  return (digits & 0x0000FFFF0000FFFFU) * (1 + (std::uint64_t{10000} << 32)) >> 32;
}

inline constexpr std::uint64_t kPowersOfTen[] = {1,       10,        100,        1000,       10'000,
                                                 100'000, 1'000'000, 10'000'000, 100'000'000};
inline constexpr double kExactPowersOfTen[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                               1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                               1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// Appends the digits at `at` to `value`, 16 at most, and moves past them. Returns their count.
inline unsigned read_digits(const char*& at, std::uint64_t& value) {
  unsigned total = 0;
  for (int half = 0; half < 2; ++half) {
    const std::uint64_t bytes = eight_bytes(at);
    const unsigned count = leading_digits(bytes);
    if (count == 0) break;
    value = value * kPowersOfTen[count] + value_of_eight(bytes << (64 - 8 * count));
    at += count;
    total += count;
    if (count < 8) break;
  }
  return total;
}

}  // namespace detail

/// Reads "-12.375" and moves past it: an optional minus, digits with at most one point, at most 16 of them
/// and together below 2^53, so that one division rounds the number as the exact one (Clinger 1990). False,
/// and nothing has happened, for any other text. The caller looks at what follows.
inline bool read_plain_decimal(const char*& at, double& number) {
  const bool negative = *at == '-';
  const char* p = at + negative;
  std::uint64_t value = 0;
  unsigned digits = 1, decimals = 0;
  if (p[1] == '.' && detail::is_digit(*p)) {
    value = static_cast<std::uint64_t>(*p++ -
                                       '0');  // a guess that is mostly right, and need not wait for a count
  } else {
    digits = detail::read_digits(p, value);
  }
  if (*p == '.') {
    ++p;
    decimals = detail::read_digits(p, value);
    digits += decimals;
  }
  if (digits == 0 || digits > 16 || value >> 53 != 0) return false;
  const double size =
      static_cast<double>(static_cast<std::int64_t>(value)) / detail::kExactPowersOfTen[decimals];
  // Signs are as good as random; no branch on them.
  number = std::bit_cast<double>(std::bit_cast<std::uint64_t>(size) | std::uint64_t{negative} << 63);
  at = p;
  return true;
}

/// Reads up to eight digits. False for none; a ninth stays where it is.
inline bool read_plain_integer(const char*& at, std::uint32_t& number) {
  const std::uint64_t bytes = detail::eight_bytes(at);
  const unsigned count = detail::leading_digits(bytes);
  if (count == 0) return false;
  number = static_cast<std::uint32_t>(detail::value_of_eight(bytes << (64 - 8 * count)));
  at += count;
  return true;
}

}  // namespace burnish
