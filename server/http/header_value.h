// The small grammar that header values share: lists, parameters, quoted strings, qualities.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace burnish {

/// The pieces between separators that are not inside double quotes, without blanks around them.
std::vector<std::string_view> split_value(std::string_view value, char separator);

bool same_ignoring_case(std::string_view a, std::string_view b);

/// Whether a list holds the item: "close" in "Keep-Alive, Close".
bool value_names(std::string_view list, std::string_view item);

/// The parameter of that name, unquoted: "x" in 'multipart/form-data; boundary="x"'.
std::optional<std::string> parameter_of(std::string_view value, std::string_view name);

/// "q=0.5" among the parameters; 1 when there is none, 0 when it cannot be read.
double quality_of(std::string_view item);

}  // namespace burnish
