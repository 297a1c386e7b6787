// What Content-Type and Accept say.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/io/codec.h"

namespace burnish {

inline constexpr std::string_view kJsonType = "application/json";
inline constexpr std::string_view kAnyBytesType = "application/octet-stream";

std::string_view media_type_of(Format format);  ///< "model/obj"

/// Without parameters, in lower case: "model/obj" of "Model/OBJ; charset=utf-8".
std::string media_type(std::string_view content_type);

bool is_form(std::string_view content_type);  ///< multipart/form-data

/// Unset for types that leave it to the content: none, application/octet-stream, text/plain and what curl
/// sends unasked. Errors: UnsupportedFormat.
Result<std::optional<Format>> mesh_format(std::string_view content_type);

/// The offer that an Accept header likes best, by the quality of the most specific range; of equals the
/// first. Without a header all are liked. Nothing: none is accepted.
std::optional<std::string_view> best_offer(std::string_view accept, std::span<const std::string_view> offers);

}  // namespace burnish
