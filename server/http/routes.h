// Every path that HTTP answers. The gateway and the OpenAPI document both start here.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace burnish {

enum class Endpoint : std::uint8_t {
  Smooth,
  Compare,
  Jobs,
  Job,
  JobEvents,
  JobMesh,
  JobReport,
  Uploads,
  Upload,
  Methods,
  OpenApi,
  Live,
  Ready,
  Metrics
};

struct Route {
  std::string_view path;  ///< "{id}" stands for one segment
  Endpoint endpoint;
  std::string_view verbs = "GET, HEAD, OPTIONS";  ///< as in the header Allow

  /// Its POST brings a mesh to work on.
  bool takes_meshes() const {
    return endpoint == Endpoint::Smooth || endpoint == Endpoint::Compare || endpoint == Endpoint::Jobs;
  }
  /// Its POST and PATCH bring bytes that are kept as they come.
  bool takes_uploads() const { return endpoint == Endpoint::Uploads || endpoint == Endpoint::Upload; }
  /// About jobs and uploads that outlive their call.
  bool is_kept() const { return path.starts_with("/v1/jobs") || path.starts_with("/v1/uploads"); }
  /// What monitors ask every few seconds.
  bool is_probe() const {
    return endpoint == Endpoint::Live || endpoint == Endpoint::Ready || endpoint == Endpoint::Metrics;
  }
  /// Answers without a token: probes that a supervisor sends.
  bool is_open() const { return endpoint == Endpoint::Live || endpoint == Endpoint::Ready; }
  bool allows(std::string_view verb) const {
    for (std::string_view rest = verbs;;) {
      const std::size_t end = rest.find(", ");
      if (rest.substr(0, end) == verb) return true;
      if (end == std::string_view::npos) return false;
      rest.remove_prefix(end + 2);
    }
  }
};

inline constexpr std::array kRoutes{
    Route{"/v1/smooth", Endpoint::Smooth, "POST, OPTIONS"},
    Route{"/v1/compare", Endpoint::Compare, "POST, OPTIONS"},
    Route{"/v1/jobs", Endpoint::Jobs, "GET, HEAD, POST, OPTIONS"},
    Route{"/v1/jobs/{id}", Endpoint::Job, "GET, HEAD, DELETE, OPTIONS"},
    Route{"/v1/jobs/{id}/events", Endpoint::JobEvents, "GET, OPTIONS"},
    Route{"/v1/jobs/{id}/mesh", Endpoint::JobMesh},
    Route{"/v1/jobs/{id}/report", Endpoint::JobReport},
    Route{"/v1/uploads", Endpoint::Uploads, "POST, OPTIONS"},
    Route{"/v1/uploads/{id}", Endpoint::Upload, "GET, HEAD, PATCH, DELETE, OPTIONS"},
    Route{"/v1/methods", Endpoint::Methods},
    Route{"/livez", Endpoint::Live},
    Route{"/readyz", Endpoint::Ready},
    Route{"/metrics", Endpoint::Metrics},
    Route{"/openapi.json", Endpoint::OpenApi},
};

/// What stands in the place of "{id}"; empty when the path is not the route's.
inline std::string_view id_in(std::string_view path, const Route& route) {
  const std::size_t at = route.path.find("{id}");
  if (at == std::string_view::npos || !path.starts_with(route.path.substr(0, at))) return {};
  const std::string_view rest = path.substr(at), after = route.path.substr(at + 4);
  const std::string_view id = rest.substr(0, rest.find('/'));
  return rest.substr(id.size()) == after ? id : std::string_view();
}

/// Null for a path that does not exist.
inline const Route* find_route(std::string_view path) {
  const auto* const found = std::ranges::find_if(
      kRoutes, [path](const Route& route) { return route.path == path || !id_in(path, route).empty(); });
  return found == kRoutes.end() ? nullptr : found;
}

}  // namespace burnish
