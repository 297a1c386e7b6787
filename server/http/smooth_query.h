// POST /v1/smooth without its body: what the query string and the headers ask for.
#pragma once

#include <chrono>
#include <optional>

#include "burnish/v1/smoothing.pb.h"
#include "core/io/codec.h"
#include "server/http/http_message.h"

namespace burnish {

struct SmoothQuery {
  std::optional<Format> format;  ///< of the body; unset: told by content
  v1::SmoothOptions options;
  std::optional<std::chrono::milliseconds> timeout;
};

/// Query: method, output=obj|drc, timeout_ms, draco_method=sequential|edgebreaker, position_bits,
/// normal_bits, texture_coordinate_bits, color_bits, generic_bits, speed; every other name is a parameter of
/// the method. Errors: UnknownMethod, UnknownOption, BadOption (a name given twice, a bad value), each naming
/// the parameter; UnsupportedFormat for a Content-Type or Content-Encoding that is not understood.
Result<SmoothQuery> parse_smooth_query(const HttpRequest& request);

}  // namespace burnish
