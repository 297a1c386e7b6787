// The log: one line per event on standard error.
#pragma once

#include <string>
#include <string_view>

namespace burnish {

/// Names of the levels that set_up_log() takes.
inline constexpr const char* kLogLevels[] = {"debug", "info", "warn", "error", "off"};

/// Sends the log, and gRPC's own at debug, to standard error from `level` on. Call once, before threads
/// start.
void set_up_log(const std::string& level);

/// `text` as printable ASCII of at most `longest` characters: foreign text must neither break a log line nor
/// overflow gRPC's 8 KiB of metadata.
std::string printable(std::string_view text, std::size_t longest = 1000);

}  // namespace burnish
