// How noisy a scan is, from the scan alone.
#pragma once

#include <span>
#include <string_view>

#include "core/mesh/surface.h"

namespace burnish {

struct NoiseEstimate {
  enum class Kind : std::uint8_t {
    None,       ///< nothing that smoothing should take away
    Gaussian,   ///< every vertex is off
    Impulsive,  ///< few vertices are off, by much more than the others
  };
  /// Root mean square distance of the vertices from the true surface, over its mean edge length; what counts
  /// as true is what neighbours of neighbours agree on. Within 20% from 0.05 to 0.7 for noise that is
  /// independent between vertices.
  double sigma_over_edge = 0;
  Kind kind = Kind::None;
};

/// "none", "gaussian", "impulsive"
std::string_view name_of(NoiseEstimate::Kind kind);

/// Of the surface with these positions for its own. Meaningless when stopped: ask run.stopped().
NoiseEstimate estimate_noise(const Surface& surface, std::span<const Vec3f> positions, const RunControl& run);

}  // namespace burnish
