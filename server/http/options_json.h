// The part `options` of a multipart request: SmoothOptions as JSON.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "burnish/v1/smoothing.pb.h"
#include "server/service/smooth_service.h"

namespace burnish {

/// The protobuf JSON mapping, stricter: names in lowerCamelCase or as in the contract, whole numbers without
/// fraction, enums by name ("MESH_FORMAT_OBJ") or its last word ("obj", and "drc" for Draco), nothing null,
/// nothing twice. Also checks what the service checks of options. Errors: BadOption, UnknownOption,
/// UnknownMethod, and TooLarge (max-option-bytes); message and field hold the path,
/// "options.output.draco.positionBits".
Result<v1::SmoothOptions> parse_options_json(std::string_view text, const SmoothService& service);

/// What an enum's values are called beside their full names, "unspecified" left out.
std::vector<std::string> short_names(const google::protobuf::EnumDescriptor& type);

}  // namespace burnish
