#include "core/io/text_number.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace burnish {
namespace {

constexpr int kMostDecimals = 15;
constexpr double kExactIntegers = 0x1p53;
constexpr std::size_t kLongest = 40;  // of one number: a sign, 17 digits, a point and an exponent are less

constexpr auto kPairs = [] {  // "000102...99"
  std::array<char, 200> pairs{};
  for (std::size_t i = 0; i < 100; ++i) {
    pairs[2 * i] = static_cast<char>('0' + i / 10);
    pairs[2 * i + 1] = static_cast<char>('0' + i % 10);
  }
  return pairs;
}();

int decimals_for(const Frame& frame) {
  constexpr double kLog10Of2 = 0.301029995663981195;
  const int decimals = static_cast<int>(std::ceil((24 - frame.exponent) * kLog10Of2));
  return decimals < 0 ? 0 : decimals;
}

}  // namespace

DecimalWriter::DecimalWriter(const Frame& frame) : DecimalWriter(decimals_for(frame)) {}

DecimalWriter::DecimalWriter(int decimals) : decimals_(decimals <= kMostDecimals ? decimals : -1) {
  for (int i = 0; i < decimals_; ++i) power_ *= 10;
}

char* DecimalWriter::write(char* to, double value) const {
  const double scaled = std::abs(value * power_);
  if (decimals_ < 0 || !(scaled < kExactIntegers)) return std::to_chars(to, to + kLongest, value).ptr;
  auto rest = static_cast<std::uint64_t>(scaled);
  rest += scaled - static_cast<double>(rest) >= 0.5;
  if (value < 0 && rest > 0) *to++ = '-';
  // Digits two at a time from the last, at least one before the point.
  char digits[20];
  char* const end = digits + sizeof digits;
  char* first = end;
  while (rest > 0 || end - first <= decimals_) {
    std::memcpy(first -= 2, &kPairs[rest % 100 * 2], 2);
    rest /= 100;
  }
  char* const point = end - decimals_;
  while (*first == '0' && first + 1 < point) ++first;
  to = std::copy(first, point, to);
  if (decimals_ == 0) return to;
  *to++ = '.';
  return std::copy(point, end, to);
}

void DecimalWriter::append(std::string& out, double value) const {
  char buffer[kLongest];
  out.append(buffer, write(buffer, value));
}

void DecimalWriter::append(std::string& out, const Vec3d& v) const {
  char buffer[3 * kLongest + 2];
  char* at = write(buffer, v.x);
  *at++ = ' ';
  at = write(at, v.y);
  *at++ = ' ';
  out.append(buffer, write(at, v.z));
}

double DecimalWriter::largest_error() const { return decimals_ < 0 ? 0 : std::sqrt(3.0) / 2 / power_; }

}  // namespace burnish
