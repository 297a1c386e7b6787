#include "core/measure/triangle_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/mesh/simd_vec3.h"
#include "core/run/math.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// Every function below is inlined into entry points that are compiled for one vector width each.
#define BURNISH_INLINE [[gnu::always_inline]] inline

namespace burnish::triangle_sums {
namespace {

using Floats = SimdVec3::Lanes;
using Doubles = double __attribute__((vector_size(32)));
using Vectors = Vec3<Doubles>;
constexpr std::size_t kLanes = 4;

BURNISH_INLINE double sum_of(const Doubles& lanes) { return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]); }
BURNISH_INLINE double largest_of(const Doubles& lanes) {
  return std::max(std::max(lanes[0], lanes[1]), std::max(lanes[2], lanes[3]));
}
BURNISH_INLINE Doubles larger(const Doubles& a, const Doubles& b) { return a > b ? a : b; }
/// Square roots, without the errno of the library's, which keeps them apart. By halves that stay in
/// registers: what is stored by halves and loaded as one waits for the memory.
BURNISH_INLINE Doubles root(const Doubles& lanes) {
#if defined(__x86_64__)
  const __m128d low = _mm_sqrt_pd(__builtin_shufflevector(lanes, lanes, 0, 1)),
                high = _mm_sqrt_pd(__builtin_shufflevector(lanes, lanes, 2, 3));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3);
#else
  return Doubles{std::sqrt(lanes[0]), std::sqrt(lanes[1]), std::sqrt(lanes[2]), std::sqrt(lanes[3])};
#endif
}
BURNISH_INLINE Doubles times(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
BURNISH_INLINE Vectors minus(const Vectors& a, const Vectors& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
BURNISH_INLINE Vectors across(const Vectors& a, const Vectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// portable_angle() in each lane, to the bit; of what is no number, any angle.
BURNISH_INLINE Doubles angle_of(const Doubles& y, const Doubles& x) {
  using FourInts = std::int32_t __attribute__((vector_size(16)));
  constexpr Doubles kZero{};
  const Doubles size = x < kZero ? -x : x;
  const auto steep = y > size;
  const Doubles over = steep ? size : y, under = steep ? y : size;
  Doubles t = over / under;
  t = t <= kZero + 1 ? t : kZero;  // 0/0, and what is no number
  // The nearest sixteenth takes most of the angle; of the rest, below 1/32, six terms of the series reach
  // double accuracy.
  const auto nearest = __builtin_convertvector(t * 16 + 0.5, FourInts);
  const Doubles sixteenths = __builtin_convertvector(nearest, Doubles) / 16;
  const Doubles table = {kArctangents[nearest[0]], kArctangents[nearest[1]], kArctangents[nearest[2]],
                         kArctangents[nearest[3]]};
  const Doubles rest = (t - sixteenths) / (t * sixteenths + 1), s = rest * rest;
  Doubles sum = kZero;
  for (int k = 11; k >= 1; k -= 2) sum = 1.0 / k - s * sum;
  Doubles acute = table + rest * sum;
  acute = steep ? kPi / 2 - acute : acute;
  return x < kZero ? kPi - acute : acute;
}

/// Lane by lane the compiler makes one instruction of it, of __builtin_convertvector four.
BURNISH_INLINE Doubles to_doubles(const Floats& lanes) {
  return Doubles{lanes[0], lanes[1], lanes[2], lanes[3]};
}

/// One vertex per lane.
BURNISH_INLINE Vectors gather(std::span<const Vec3f> positions, const Index (&vertices)[kLanes]) {
  Floats rows[kLanes], axes[3];
  for (std::size_t i = 0; i < kLanes; ++i) rows[i] = SimdVec3(positions[vertices[i]]).lanes();
  by_axis(rows, axes);
  return {to_doubles(axes[0]), to_doubles(axes[1]), to_doubles(axes[2])};
}

/// Four triangles by corner; at the end the last one again, with the weight 0.
struct Quad {
  Index corners[3][kLanes];
  Doubles weight;

  BURNISH_INLINE Quad(std::span<const Triangle> triangles, std::size_t first) {
    const std::size_t count = triangles.size() - first;
    if (count >= kLanes) {
      take(&triangles[first]);
      weight = Doubles{1, 1, 1, 1};
    } else {
      Triangle some[kLanes];
      for (std::size_t i = 0; i < kLanes; ++i) some[i] = triangles[first + std::min(i, count - 1)];
      take(some);
      weight = Doubles{1, count > 1 ? 1.0 : 0.0, count > 2 ? 1.0 : 0.0, 0};
    }
  }

 private:
  BURNISH_INLINE void take(const Triangle* four) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      for (std::size_t c = 0; c < 3; ++c) corners[c][i] = four[i][c];
    }
  }
};

BURNISH_INLINE Shape shape_of(std::span<const Triangle> triangles, std::span<const Vec3f> positions) {
  Doubles area{}, volume{}, sharpest_dot{}, sharpest_cross = Doubles{} + 1;
  for (std::size_t t = 0; t < triangles.size(); t += kLanes) {
    const Quad quad(triangles, t);
    const Vectors a = gather(positions, quad.corners[0]), b = gather(positions, quad.corners[1]),
                  c = gather(positions, quad.corners[2]);
    const Vectors ab = minus(b, a), bc = minus(c, b), ca = minus(a, c), normal = across(ab, bc);
    const Doubles twice_area = root(times(normal, normal));
    area += twice_area * quad.weight;
    volume += times(a, across(b, c)) * quad.weight;
    const Doubles largest = larger(larger(-times(ab, ca), -times(ab, bc)), -times(bc, ca));
    const Doubles zero{}, dot = twice_area > zero ? largest : zero + 1;
    const auto sharper = sharpest_dot * twice_area < dot * sharpest_cross;
    sharpest_dot = sharper ? dot : sharpest_dot;
    sharpest_cross = sharper ? twice_area : sharpest_cross;
  }
  Shape shape{sum_of(area) / 2, sum_of(volume) / 6, {}};
  for (std::size_t i = 0; i < kLanes; ++i)
    shape.sharpest = std::max(shape.sharpest, Cotangent{sharpest_dot[i], sharpest_cross[i]});
  return shape;
}

BURNISH_INLINE Vectors area_normal(std::span<const Vec3f> positions, const Quad& quad) {
  const Vectors a = gather(positions, quad.corners[0]);
  return across(minus(gather(positions, quad.corners[1]), a), minus(gather(positions, quad.corners[2]), a));
}

BURNISH_INLINE Doubles gather(std::span<const double> values, const Index (&vertices)[kLanes]) {
  return Doubles{values[vertices[0]], values[vertices[1]], values[vertices[2]], values[vertices[3]]};
}

/// What the angles between some normals come from. Angles are found in a loop of their own: the chain from a
/// root to its arctangent is long, and of what stands in one short loop the processor works on many at once.
struct AngleChunk {
  static constexpr std::size_t kMost = 64;
  Doubles squared_cross[kMost], dot[kMost], weight[kMost];  // weight 0: an area that is none
  std::size_t count = 0;
};

struct AngleSums {
  Doubles angles{}, largest{}, compared{}, flipped{};

  BURNISH_INLINE void add(AngleChunk& chunk) {
    const Doubles zero{}, right_angle = zero + kPi / 2;
    for (std::size_t i = 0; i < chunk.count; ++i) {
      const Doubles counts = chunk.weight[i];
      const Doubles angle = angle_of(root(chunk.squared_cross[i]), chunk.dot[i]);
      const Doubles counted = counts > zero ? angle : zero;
      angles += counted;
      largest = larger(counted, largest);
      compared += counts;
      flipped += counted > right_angle ? counts : zero;
    }
    chunk.count = 0;
  }
};

BURNISH_INLINE Errors errors_of(std::span<const Triangle> triangles, std::span<const Vec3f> positions,
                                std::span<const double> squared, std::span<const Vec3f> others) {
  const Doubles zero{};
  Doubles area{}, weighted{};
  AngleChunk chunk;
  AngleSums sums;
  for (std::size_t t = 0; t < triangles.size(); t += kLanes) {
    const Quad quad(triangles, t);
    const Vectors ours = area_normal(positions, quad);
    const Doubles size = times(ours, ours), twice_area = root(size) * quad.weight;
    area += twice_area;
    weighted += twice_area * (gather(squared, quad.corners[0]) + gather(squared, quad.corners[1]) +
                              gather(squared, quad.corners[2]));
    if (others.empty()) continue;
    const Vectors theirs = area_normal(others, quad), both = across(ours, theirs);
    chunk.squared_cross[chunk.count] = times(both, both);
    chunk.dot[chunk.count] = times(ours, theirs);
    chunk.weight[chunk.count] = ((size > zero) & (times(theirs, theirs) > zero)) ? quad.weight : zero;
    if (++chunk.count == AngleChunk::kMost) sums.add(chunk);
  }
  sums.add(chunk);
  return {sum_of(area) / 2,
          sum_of(weighted) / 2,
          sum_of(sums.angles),
          largest_of(sums.largest),
          static_cast<std::uint32_t>(sum_of(sums.compared)),
          static_cast<std::uint32_t>(sum_of(sums.flipped))};
}

Shape shape_128(std::span<const Triangle> triangles, std::span<const Vec3f> positions) {
  return shape_of(triangles, positions);
}
Errors errors_128(std::span<const Triangle> triangles, std::span<const Vec3f> positions,
                  std::span<const double> squared, std::span<const Vec3f> others) {
  return errors_of(triangles, positions, squared, others);
}
#if defined(__x86_64__)
[[gnu::target("avx2")]] Shape shape_256(std::span<const Triangle> triangles,
                                        std::span<const Vec3f> positions) {
  return shape_of(triangles, positions);
}
[[gnu::target("avx2")]] Errors errors_256(std::span<const Triangle> triangles,
                                          std::span<const Vec3f> positions, std::span<const double> squared,
                                          std::span<const Vec3f> others) {
  return errors_of(triangles, positions, squared, others);
}
#endif

}  // namespace

std::vector<Functions> functions_here() {
  std::vector<Functions> here{{shape_128, errors_128}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) here.push_back({shape_256, errors_256});
#endif
  return here;
}

const Functions& functions() {
  static const Functions kWidest = functions_here().back();
  return kWidest;
}

}  // namespace burnish::triangle_sums
