#include "server/http/header_value.h"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace burnish {
namespace {

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string unquote(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::string(text);
  std::string plain;
  text = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size()) ++i;
    plain += text[i];
  }
  return plain;
}

}  // namespace

std::vector<std::string_view> split_value(std::string_view value, char separator) {
  std::vector<std::string_view> pieces;
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (quoted && value[i] == '\\') {
      ++i;
    } else if (value[i] == '"') {
      quoted = !quoted;
    } else if (!quoted && value[i] == separator) {
      pieces.push_back(trim(value.substr(begin, i - begin)));
      begin = i + 1;
    }
  }
  pieces.push_back(trim(value.substr(begin)));
  return pieces;
}

bool same_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, {}, [](unsigned char c) { return std::tolower(c); },
      [](unsigned char c) { return std::tolower(c); });
}

bool value_names(std::string_view list, std::string_view item) {
  return std::ranges::any_of(split_value(list, ','),
                             [item](std::string_view each) { return same_ignoring_case(each, item); });
}

std::optional<std::string> parameter_of(std::string_view value, std::string_view name) {
  const auto pieces = split_value(value, ';');
  for (auto piece = pieces.begin() + 1; piece != pieces.end(); ++piece) {
    const std::size_t equals = piece->find('=');
    if (equals == std::string_view::npos || !same_ignoring_case(trim(piece->substr(0, equals)), name))
      continue;
    return unquote(trim(piece->substr(equals + 1)));
  }
  return {};
}

double quality_of(std::string_view item) {
  const auto text = parameter_of(item, "q");
  if (!text) return 1;
  double quality = 0;
  const char* const end = text->data() + text->size();
  const auto [stop, failure] = std::from_chars(text->data(), end, quality);
  return failure == std::errc() && stop == end && quality >= 0 && quality <= 1 ? quality : 0;
}

}  // namespace burnish
