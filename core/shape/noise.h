// Artificial scanner noise, for demonstrations and measurements. Amplitudes are multiples of the mean edge
// length h. The same seed gives the same bytes on every machine: the generator is std::mt19937_64 and the
// distributions are our own, without the C library's functions that differ between processors.
#pragma once

#include <cstdint>

#include "core/mesh/surface.h"

namespace burnish {

enum class NoiseKind : std::uint8_t {
  Gaussian,   ///< standard deviation: amplitude * h
  Uniform,    ///< evenly from -amplitude * h to +amplitude * h
  Impulsive,  ///< Uniform, at a random `fraction` of the vertices; the others stay
};

enum class NoiseDirection : std::uint8_t {
  Normal,  ///< along the vertex normal, the area-weighted sum of the face normals
  Random,  ///< each coordinate on its own
};

struct NoiseOptions {
  NoiseKind kind = NoiseKind::Gaussian;
  NoiseDirection direction = NoiseDirection::Normal;
  double amplitude = 0.2;  ///< mean edge lengths, 0 to 100
  double fraction = 0.1;   ///< for Impulsive, 0 to 1
  std::uint64_t seed = 1;
};

/// Moves surface.mesh.positions; vertices that the file repeats move as one, vertices in no triangle stay.
/// Errors: BadOption.
Result<> add_noise(Surface& surface, const NoiseOptions& options);

}  // namespace burnish
