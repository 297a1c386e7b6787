// The parts of the OpenAPI document that its operations share.
#pragma once

#include <set>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "server/service/limits.h"

namespace burnish {

/// {"$ref": "#/components/KIND/NAME"}
nlohmann::ordered_json openapi_reference(const std::string& kind, const std::string& name);

/// One media type with its schema.
nlohmann::ordered_json openapi_content(std::string_view type, nlohmann::ordered_json schema);

/// A mesh file in any of the formats.
nlohmann::ordered_json openapi_mesh_content();

nlohmann::ordered_json query_parameter(const std::string& name, nlohmann::ordered_json schema,
                                       const std::string& text);

nlohmann::ordered_json openapi_answer_headers();  ///< those of every answer

nlohmann::ordered_json problem_reference(int status);
nlohmann::ordered_json other_problem_reference();  ///< any other 4xx

/// Statuses by which a request with meshes may fail.
std::set<int> problem_statuses_of_work();

nlohmann::ordered_json openapi_components(const RequestLimits& limits);

}  // namespace burnish
