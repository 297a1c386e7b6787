#include "server/http/byte_range.h"

#include <algorithm>
#include <charconv>
#include <string>

namespace burnish {
namespace {

/// Digits alone. Nothing when it is no number, or more than 64 bits.
std::optional<std::uint64_t> number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.begin(), text.end(), value);
  if (failure != std::errc() || end != text.end()) return {};
  return value;
}

}  // namespace

Result<std::optional<ByteRange>> parse_range(std::string_view header, std::uint64_t size) {
  constexpr std::string_view kBytes = "bytes=";
  const std::optional<ByteRange> all;
  if (!header.starts_with(kBytes)) return all;
  header.remove_prefix(kBytes.size());
  const std::size_t dash = header.find('-');
  if (dash == std::string_view::npos) return all;
  const std::string_view from = header.substr(0, dash), to = header.substr(dash + 1);
  const Error beyond{Cause::RangeNotSatisfiable,
                     "the range begins behind the last of " + std::to_string(size) + " bytes"};
  if (from.empty()) {  // the last so many
    const auto last = number(to);
    if (!last) return all;
    if (*last == 0 || size == 0) return beyond;
    const std::uint64_t count = std::min(*last, size);
    return std::optional(ByteRange{size - count, count});
  }
  const auto first = number(from);
  const auto last = to.empty() ? std::optional(UINT64_MAX) : number(to);
  if (!first || !last || *last < *first) return all;
  if (*first >= size) return beyond;
  return std::optional(ByteRange{*first, std::min(*last, size - 1) - *first + 1});
}

}  // namespace burnish
