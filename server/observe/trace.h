// W3C Trace Context: the caller's trace, so that its log and ours can be joined.
#pragma once

#include <string>
#include <string_view>

namespace burnish {

/// The trace id of a traceparent header, 32 hexadecimal digits; empty when the header is absent or malformed.
std::string trace_id_of(std::string_view traceparent);

}  // namespace burnish
