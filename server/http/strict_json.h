// JSON from strangers: nothing is guessed, nothing is skipped, and nothing nests deep enough to hurt.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/run/error.h"

namespace burnish {

inline constexpr std::size_t kDeepestJson = 32;  ///< arrays and objects in one another

/// Reads RFC 8259 text. Errors: BadOption for what is not JSON (trailing text and bad UTF-8 too), a name
/// given twice in one object, null, a number beyond double, deeper nesting; message and field say where, as
/// "options.output[2].format" with `root` as the first word.
Result<nlohmann::json> parse_strict_json(std::string_view text, const std::string& root);

}  // namespace burnish
