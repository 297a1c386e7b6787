// Every path that HTTP answers. The gateway and the OpenAPI document both start here.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace burnish {

enum class Endpoint : std::uint8_t { Smooth, Compare, Methods, OpenApi, Live, Ready, Metrics };

struct Route {
  std::string_view path;
  Endpoint endpoint;

  bool takes_meshes() const { return endpoint == Endpoint::Smooth || endpoint == Endpoint::Compare; }
  /// What monitors ask every few seconds.
  bool is_probe() const {
    return endpoint == Endpoint::Live || endpoint == Endpoint::Ready || endpoint == Endpoint::Metrics;
  }
  std::string_view verbs() const { return takes_meshes() ? "POST, OPTIONS" : "GET, HEAD, OPTIONS"; }
};

inline constexpr std::array kRoutes{
    Route{"/v1/smooth", Endpoint::Smooth},     Route{"/v1/compare", Endpoint::Compare},
    Route{"/v1/methods", Endpoint::Methods},   Route{"/livez", Endpoint::Live},
    Route{"/readyz", Endpoint::Ready},         Route{"/metrics", Endpoint::Metrics},
    Route{"/openapi.json", Endpoint::OpenApi},
};

/// Null for a path that does not exist.
inline const Route* find_route(std::string_view path) {
  const auto* const found = std::ranges::find(kRoutes, path, &Route::path);
  return found == kRoutes.end() ? nullptr : found;
}

}  // namespace burnish
