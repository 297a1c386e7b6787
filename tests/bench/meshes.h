// The meshes that every benchmark uses: noisy rings, each made once per program and only when asked for.
#pragma once

#include <cmath>
#include <map>
#include <random>

#include "tests/support/shapes.h"

namespace burnish::bench {

/// Triangles, 4 n^2: about 20k, 70k, 280k, 1.1M and 4.4M.
inline constexpr int kSizes[] = {20164, 69696, 280900, 1098304, 4401604};

/// A torus of about `triangles` triangles. Squares are split along either diagonal at random, so that
/// vertices have 4 to 8 neighbours, as those of a scan have.
inline const testing::Shape& clean_mesh(int triangles) {
  static std::map<int, testing::Shape> made;
  const auto [at, added] = made.try_emplace(triangles);
  testing::Shape& shape = at->second;
  if (!added) return shape;
  const int along = static_cast<int>(std::lround(std::sqrt(triangles / 4.0))), around = 2 * along;
  const auto vertex = [=](int i, int j) { return static_cast<Index>(i % around * along + j % along); };
  std::mt19937 either(1);
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < along; ++j) {
      const double u = 2 * M_PI * i / around, v = 2 * M_PI * j / along, r = 2 + std::cos(v);
      shape.positions.push_back({r * std::cos(u), r * std::sin(u), std::sin(v)});
      const Index a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
      const bool turned = (either() & 1U) != 0;
      shape.triangles.push_back(turned ? Triangle{a, b, d} : Triangle{a, b, c});
      shape.triangles.push_back(turned ? Triangle{b, c, d} : Triangle{a, c, d});
    }
  }
  return shape;
}

/// With noise of up to a fifth of an edge, as a scanner leaves it.
inline const testing::Shape& noisy_mesh(int triangles) {
  static std::map<int, testing::Shape> made;
  const auto [at, added] = made.try_emplace(triangles);
  const double edge = 2 * M_PI / std::sqrt(triangles / 4.0);
  if (added) at->second = testing::with_noise(clean_mesh(triangles), 0.2 * edge);
  return at->second;
}

inline const Surface& noisy_surface(int triangles) {
  static std::map<int, Surface> made;
  const auto [at, added] = made.try_emplace(triangles);
  if (added) at->second = testing::surface_of(noisy_mesh(triangles));
  return at->second;
}

}  // namespace burnish::bench
