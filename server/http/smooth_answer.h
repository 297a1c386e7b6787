// What POST /v1/smooth answers when all went well.
#pragma once

#include <string_view>

#include "server/http/http_message.h"
#include "server/service/smooth_service.h"

namespace burnish {

/// The media type that an Accept header likes best: the mesh's own, application/octet-stream (the mesh too),
/// or application/json. `format` of the mesh; unset: not known yet. Errors: NotAcceptable.
Result<std::string_view> choose_smooth_answer(std::string_view accept, std::optional<Format> format);

/// The format of the job's result, as far as it can be told without decoding.
std::optional<Format> result_format(const SmoothJob& job);

/// The mesh with its report in a header, or for application/json a SmoothResponse in protobuf JSON.
HttpResponse smooth_answer(SmoothResult result, std::string_view media_type);

}  // namespace burnish
