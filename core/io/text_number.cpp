#include "core/io/text_number.h"

#include <charconv>
#include <cmath>

namespace burnish {
namespace {

constexpr int kMostDecimals = 15;
constexpr double kExactIntegers = 0x1p53;

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

void DecimalWriter::append(std::string& out, double value) const {
  char buffer[40];
  const double scaled = value * power_;
  if (decimals_ < 0 || !(std::abs(scaled) < kExactIntegers)) {
    out.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
    return;
  }
  const long long rounded = std::llround(scaled);
  unsigned long long rest = static_cast<unsigned long long>(std::llabs(rounded));
  char* const end = buffer + sizeof buffer;
  char* at = end;
  for (int i = 0; i < decimals_; ++i, rest /= 10) *--at = static_cast<char>('0' + rest % 10);
  if (decimals_ > 0) *--at = '.';
  do {
    *--at = static_cast<char>('0' + rest % 10);
    rest /= 10;
  } while (rest > 0);
  if (rounded < 0) *--at = '-';
  out.append(at, end);
}

void DecimalWriter::append(std::string& out, const Vec3d& v) const {
  append(out, v.x);
  out += ' ';
  append(out, v.y);
  out += ' ';
  append(out, v.z);
}

double DecimalWriter::largest_error() const { return decimals_ < 0 ? 0 : std::sqrt(3.0) / 2 / power_; }

}  // namespace burnish
