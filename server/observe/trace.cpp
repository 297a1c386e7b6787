#include "server/observe/trace.h"

#include <algorithm>

namespace burnish {
namespace {

/// Lower case only, as the standard has it.
bool is_hexadecimal(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_zero(std::string_view text) { return text.find_first_not_of('0') == std::string_view::npos; }

}  // namespace

std::string trace_id_of(std::string_view traceparent) {
  // version-trace-parent-flags; versions after 00 may go on after another dash.
  constexpr std::size_t kLength = 55;
  if (traceparent.size() < kLength) return {};
  const auto version = traceparent.substr(0, 2), trace = traceparent.substr(3, 32),
             parent = traceparent.substr(36, 16), flags = traceparent.substr(53, 2);
  const bool dashes = traceparent[2] == '-' && traceparent[35] == '-' && traceparent[52] == '-';
  const bool digits =
      is_hexadecimal(version) && is_hexadecimal(trace) && is_hexadecimal(parent) && is_hexadecimal(flags);
  if (!dashes || !digits || version == "ff" || is_zero(trace) || is_zero(parent)) return {};
  if (traceparent.size() > kLength && (version == "00" || traceparent[kLength] != '-')) return {};
  return std::string(trace);
}

}  // namespace burnish
