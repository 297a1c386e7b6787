// The file that --config names: one JSON object, a key for each setting that it gives.
#pragma once

#include <span>
#include <string>

#include "server/config_settings.h"

namespace burnish {

/// Sets what the file gives. Errors: BadOption for a file that cannot be read or is no such object, and for
/// a key that is unknown, given twice, of the wrong type or out of range; the message names file and key.
Result<> apply_config_file(const std::string& path, std::span<const Setting> settings);

/// All settings, as apply_config_file() takes them.
std::string config_json(std::span<const Setting> settings);

}  // namespace burnish
