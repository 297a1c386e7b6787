// The schemas of the OpenAPI document, read off the contract's messages and the methods.
#pragma once

#include <nlohmann/json.hpp>

#include "server/service/limits.h"

namespace burnish {

/// "#/components/schemas/NAME"
nlohmann::ordered_json schema_reference(const std::string& name);

/// Every schema by its name: the messages of answers, SmoothOptions as requests give it, Problem.
nlohmann::ordered_json openapi_schemas(const RequestLimits& limits);

/// Query parameters of POST /v1/smooth by name, with the union of what the methods take.
nlohmann::ordered_json method_parameter_schemas(const RequestLimits& limits);

}  // namespace burnish
