// The meshes that every benchmark uses: noisy spheres, made once per program.
#pragma once

#include <map>

#include "tests/support/shapes.h"

namespace burnish::bench {

/// Subdivision levels: about 20k, 80k and 330k triangles.
inline constexpr int kLevels[] = {5, 6, 7};

inline const testing::Shape& clean_sphere(int level) {
  static std::map<int, testing::Shape> made;
  const auto [at, added] = made.try_emplace(level);
  if (added) at->second = testing::sphere(level);
  return at->second;
}

/// With noise of up to a fifth of an edge, as a scanner leaves it.
inline const testing::Shape& noisy_sphere(int level) {
  static std::map<int, testing::Shape> made;
  const auto [at, added] = made.try_emplace(level);
  if (added) at->second = testing::with_noise(clean_sphere(level), 0.2 * 1.2 / (1 << level));
  return at->second;
}

inline const Surface& noisy_surface(int level) {
  static std::map<int, Surface> made;
  const auto [at, added] = made.try_emplace(level);
  if (added) at->second = testing::surface_of(noisy_sphere(level));
  return at->second;
}

}  // namespace burnish::bench
