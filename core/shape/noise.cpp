#include "core/shape/noise.h"

#include <random>

#include "core/run/math.h"

namespace burnish {
namespace {

/// Standard distributions from a portable generator.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : bits_(seed) {}

  /// In [0, 1), every multiple of 2^-53 alike.
  double unit() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  /// In [-1, 1).
  double centred() { return 2 * unit() - 1; }

  /// Mean 0, deviation 1, cut at 8. By rejection: needs no logarithm, whose last bit depends on the
  /// processor.
  double gaussian() {
    for (;;) {
      const double x = 8 * centred();
      if (unit() < portable_exp(-0.5 * x * x)) return x;
    }
  }

 private:
  std::mt19937_64 bits_;
};

double draw(Draws& draws, NoiseKind kind) {
  return kind == NoiseKind::Gaussian ? draws.gaussian() : draws.centred();
}

std::vector<Vec3d> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3d> normals(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3d a = to_double(mesh.positions[t[0]]);
    const Vec3d twice_area = cross(to_double(mesh.positions[t[1]]) - a, to_double(mesh.positions[t[2]]) - a);
    for (const Index v : t) normals[v] += twice_area;
  }
  for (Vec3d& n : normals) {
    if (const double size = length(n); size > 0) n *= 1 / size;
  }
  return normals;
}

Result<> check(const NoiseOptions& options) {
  if (!(options.amplitude >= 0 && options.amplitude <= 100)) {
    return Error{Cause::BadOption, "amplitude must be from 0 to 100 mean edge lengths", "amplitude"};
  }
  if (!(options.fraction >= 0 && options.fraction <= 1)) {
    return Error{Cause::BadOption, "fraction must be from 0 to 1", "fraction"};
  }
  return {};
}

}  // namespace

Result<> add_noise(Surface& surface, const NoiseOptions& options) {
  if (Result<> checked = check(options); !checked) return checked;
  Mesh& mesh = surface.mesh;
  const std::vector<Vec3d> normals = vertex_normals(mesh);
  const double size = options.amplitude * surface.mean_edge;
  Draws draws(options.seed);
  std::vector<std::uint8_t> drawn(mesh.positions.size());
  for (const Index v : surface.weld) {  // in the file's order: the mesh may lie in memory in another
    if (drawn[v] != 0 || surface.topology.has(v, kIsolatedVertex)) continue;
    drawn[v] = 1;
    if (options.kind == NoiseKind::Impulsive && draws.unit() >= options.fraction) continue;
    Vec3d step;
    if (options.direction == NoiseDirection::Normal) {
      step = normals[v] * draw(draws, options.kind);
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) step[axis] = draw(draws, options.kind);
    }
    mesh.positions[v] = to_float(to_double(mesh.positions[v]) + step * size);
  }
  return {};
}

}  // namespace burnish
