// The OpenAPI document's operations on jobs and uploads.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "server/http/routes.h"

namespace burnish {

/// One verb in lower case of a route that is_kept(). `submission`: the parameters and the body of a job.
nlohmann::ordered_json kept_operation(const Route& route, const std::string& verb,
                                      nlohmann::ordered_json submission);

/// "Job" of /v1/jobs/{id}: for names of operations.
std::string kept_name(Endpoint endpoint);

}  // namespace burnish
