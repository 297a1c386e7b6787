#include "core/smooth/adaptive_kernels.h"

#include <algorithm>
#include <cmath>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// Every function below is inlined into one of few entry points, each compiled for one vector width; compiler
// vectors that the entry's processor lacks never cross a call.
#define BURNISH_INLINE [[gnu::always_inline]] inline

namespace burnish::adaptive_kernels {
namespace {

template <std::size_t kLanes>
struct Vector {
  using Type __attribute__((vector_size(kLanes * sizeof(float)))) = float;
};
template <std::size_t kLanes>
using Floats = typename Vector<kLanes>::Type;
using F4 = Floats<4>;
using F8 = Floats<8>;

template <class F>
inline constexpr std::size_t kLanesOf = sizeof(F) / sizeof(float);
/// A vector holds so many rows.
template <class F>
inline constexpr std::size_t kRowsIn = kLanesOf<F> / 4;

BURNISH_INLINE void join(F4& to, const F4 (&rows)[1]) { to = rows[0]; }
BURNISH_INLINE void join(F8& to, const F4 (&rows)[2]) {
  to = __builtin_shufflevector(rows[0], rows[1], 0, 1, 2, 3, 4, 5, 6, 7);
}
BURNISH_INLINE void split(const F4& from, F4 (&rows)[1]) { rows[0] = from; }
BURNISH_INLINE void split(const F8& from, F4 (&rows)[2]) {
  rows[0] = __builtin_shufflevector(from, from, 0, 1, 2, 3);
  rows[1] = __builtin_shufflevector(from, from, 4, 5, 6, 7);
}
template <class F>
BURNISH_INLINE void repeat(F& to, const F4& row) {
  F4 rows[kRowsIn<F>];
  for (F4& each : rows) each = row;
  join(to, rows);
}

template <class F>
BURNISH_INLINE void take_root(F& a) {
  F4 rows[kRowsIn<F>];
  split(a, rows);
#if defined(__x86_64__)
  for (F4& row : rows) row = _mm_sqrt_ps(row);
#else
  for (F4& row : rows) row = F4{std::sqrt(row[0]), std::sqrt(row[1]), std::sqrt(row[2]), std::sqrt(row[3])};
#endif
  join(a, rows);
}

/// Lanes k1 to k4 of each row, in which 4 and more count the lanes of the other vector's row.
template <int k1, int k2, int k3, int k4>
BURNISH_INLINE void pick(const F4& a, const F4& b, F4& to) {
  to = __builtin_shufflevector(a, b, k1, k2, k3, k4);
}
template <int k1, int k2, int k3, int k4>
BURNISH_INLINE void pick(const F8& a, const F8& b, F8& to) {
  constexpr auto at = [](int k, int row) { return k < 4 ? k + 4 * row : 8 + k - 4 + 4 * row; };
  to = __builtin_shufflevector(a, b, at(k1, 0), at(k2, 0), at(k3, 0), at(k4, 0), at(k1, 1), at(k2, 1),
                               at(k3, 1), at(k4, 1));
}
/// Columns of four lanes to rows, or back.
template <class F>
BURNISH_INLINE void transpose(F& a, F& b, F& c, F& d) {
  F ab, ab_high, cd, cd_high;
  pick<0, 4, 1, 5>(a, b, ab);
  pick<2, 6, 3, 7>(a, b, ab_high);
  pick<0, 4, 1, 5>(c, d, cd);
  pick<2, 6, 3, 7>(c, d, cd_high);
  pick<0, 1, 4, 5>(ab, cd, a);
  pick<2, 3, 6, 7>(ab, cd, b);
  pick<0, 1, 4, 5>(ab_high, cd_high, c);
  pick<2, 3, 6, 7>(ab_high, cd_high, d);
}

/// The sum of a row's lanes in each of its lanes: (x + z) + (y + w).
template <class F>
BURNISH_INLINE void add_across(F& a) {
  F turned;
  pick<2, 3, 0, 1>(a, a, turned);
  a += turned;
  pick<1, 0, 3, 2>(a, a, turned);
  a += turned;
}

/// No lane of a comparison is false.
template <class F, class Mask>
BURNISH_INLINE bool all_of(const Mask& mask) {
  F4 rows[kRowsIn<F>];
  split(reinterpret_cast<const F&>(mask), rows);
  using Halves __attribute__((vector_size(16))) = long long;
  Halves halves = reinterpret_cast<Halves>(rows[0]);
  for (const F4& row : rows) halves &= reinterpret_cast<Halves>(row);
  return (halves[0] & halves[1]) == -1;
}

/// e^x for x in [0, log 1.5], by its series: the next term is below 2^-25 of the sum.
template <class F>
BURNISH_INLINE void exponential(F& x) {
  const F low = 1.0F + x * (1.0F + x * (0.5F + x * (1.0F / 6)));
  const F high = 1.0F / 24 + x * (1.0F / 120 + x * (1.0F / 720 + x * (1.0F / 5040)));
  const F square = x * x;
  x = low + square * square * high;
}
constexpr float kLogOfMost = 0.405465108F;

template <class F>
struct Columns {
  F x, y, z, w;
};

/// The positions of one corner of each lane's triangle.
template <class F>
BURNISH_INLINE void load_corner(const Wings* wings, const SimdVec3* from,
                                std::array<std::uint32_t, 3> Wings::*corners, std::size_t c, Columns<F>& to) {
  F* const columns[] = {&to.x, &to.y, &to.z, &to.w};
  for (std::size_t k = 0; k < 4; ++k) {
    F4 rows[kRowsIn<F>];
    for (std::size_t r = 0; r < kRowsIn<F>; ++r)
      rows[r] = at_doubled(from, (wings[k + 4 * r].*corners)[c]).lanes();
    join(*columns[k], rows);
  }
  transpose(to.x, to.y, to.z, to.w);
}

/// Adds the area normal of the triangle across the side from `a` along `side` to `sum`, and its size to
/// sum.w.
template <class F>
BURNISH_INLINE void add_across_side(const Columns<F>& a, const Columns<F>& side, const Columns<F>& far_corner,
                                    Columns<F>& sum) {
  const F x = far_corner.x - a.x, y = far_corner.y - a.y, z = far_corner.z - a.z;
  const F nx = y * side.z - z * side.y, ny = z * side.x - x * side.z, nz = x * side.y - y * side.x;
  F size = nx * nx + ny * ny + nz * nz;
  take_root(size);
  sum.x += nx, sum.y += ny, sum.z += nz, sum.w += size;
}

template <class F>
BURNISH_INLINE void subtract(const Columns<F>& a, const Columns<F>& b, Columns<F>& to) {
  to.x = a.x - b.x, to.y = a.y - b.y, to.z = a.z - b.z;
}

/// The plane of a triangle whose neighbours cancel out, or that has none: through its own normal, if it has
/// one.
Row own_plane(const Wings& wings, const SimdVec3* from) {
  const SimdVec3 a = from[wings.corners[0] / 2], b = from[wings.corners[1] / 2],
                 c = from[wings.corners[2] / 2];
  const SimdVec3 normal = cross(b - a, c - a);
  const float size = length(normal);
  if (!(size > 0)) return Row{};
  const SimdVec3 m = normal * (1 / size);
  return Row{m.x(), m.y(), m.z(), dot(m, (a + b + c) * (1.0F / 3.0F))};
}

/// Planes of as many triangles as there are lanes.
template <class F>
BURNISH_INLINE void expect_some(const Wings* wings, const SimdVec3* from, Row* planes) {
  Columns<F> a, b, c, side, far_corner, m{};
  load_corner(wings, from, &Wings::corners, 0, a);
  load_corner(wings, from, &Wings::corners, 1, b);
  load_corner(wings, from, &Wings::corners, 2, c);
  subtract(b, a, side);
  load_corner(wings, from, &Wings::far_corners, 0, far_corner);
  add_across_side(a, side, far_corner, m);
  subtract(c, b, side);
  load_corner(wings, from, &Wings::far_corners, 1, far_corner);
  add_across_side(b, side, far_corner, m);
  subtract(a, c, side);
  load_corner(wings, from, &Wings::far_corners, 2, far_corner);
  add_across_side(c, side, far_corner, m);

  const F size = m.x * m.x + m.y * m.y + m.z * m.z, least = m.w * kVanishing;
  const auto sound = size > least * least;
  const F by = 1.0F / m.w;
  m.x *= by, m.y *= by, m.z *= by;
  m.w = (m.x * (a.x + b.x + c.x) + m.y * (a.y + b.y + c.y) + m.z * (a.z + b.z + c.z)) * (1.0F / 3.0F);
  transpose(m.x, m.y, m.z, m.w);
  const F* const columns[] = {&m.x, &m.y, &m.z, &m.w};
  for (std::size_t k = 0; k < 4; ++k) {
    F4 rows[kRowsIn<F>];
    split(*columns[k], rows);
    for (std::size_t r = 0; r < kRowsIn<F>; ++r) planes[k + 4 * r] = rows[r];
  }
  if (all_of<F>(sound)) [[likely]]
    return;
  for (std::size_t k = 0; k < kLanesOf<F>; ++k) {
    if (sound[k] == 0) planes[k] = own_plane(wings[k], from);
  }
}

template <class F>
BURNISH_INLINE void expect(const Wings* wings, const SimdVec3* from, std::size_t begin, std::size_t end,
                           Row* planes) {
  constexpr std::size_t kLanes = kLanesOf<F>;
  for (; begin + kLanes <= end; begin += kLanes) expect_some<F>(wings + begin, from, planes + begin);
  if (begin == end) return;
  Wings last[kLanes];
  Row results[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) last[k] = wings[std::min(begin + k, end - 1)];
  expect_some<F>(last, from, results);
  std::copy_n(results, end - begin, planes + begin);
}

template <class F, std::size_t kValence>
BURNISH_INLINE void move_group(const ValenceOrder::Group& group, const Row* planes, float per_squared_scale,
                               const SimdVec3* from, SimdVec3* to) {
  constexpr std::size_t kAtOnce = kRowsIn<F>;
  constexpr float kShare = 1.0F / kValence;
  F minus_one, keep;
  repeat(minus_one, F4{0, 0, 0, -1});
  repeat(keep, F4{kShare, kShare, kShare, 0});
  const std::size_t count = group.vertices.size();
  for (std::size_t i = 0; i < count; i += kAtOnce) {
    Index v[kAtOnce];
    const std::uint32_t *faces[kAtOnce], *neighbours[kAtOnce];
    F4 rows[kAtOnce];
    for (std::size_t r = 0; r < kAtOnce; ++r) {
      const std::size_t at = std::min(i + r, count - 1);  // the last one may come twice
      v[r] = group.vertices[at];
      faces[r] = group.faces.data() + at * kValence;
      neighbours[r] = group.neighbours.data() + at * kValence;
      rows[r] = from[v[r]].lanes();
    }
    F p, offset{}, u{}, gathered;
    join(p, rows);
    const F point = p + minus_one;  // times a plane (m, m . C) it gives m . P - m . C
    for (std::size_t k = 0; k < kValence; ++k) {
      for (std::size_t r = 0; r < kAtOnce; ++r) rows[r] = at_doubled(planes, faces[r][k]);
      join(gathered, rows);
      F height = gathered * point;
      add_across(height);
      offset -= gathered * height;
      for (std::size_t r = 0; r < kAtOnce; ++r) rows[r] = at_doubled(from, neighbours[r][k]).lanes();
      join(gathered, rows);
      u += gathered;
    }
    u = u * kShare - p;
    F d = u * u;
    add_across(d);
    d *= per_squared_scale;
    d = d < kLogOfMost ? d : F{} + kLogOfMost;
    exponential(d);
    p += offset * (d * keep);
    split(p, rows);
    for (std::size_t r = 0; r < kAtOnce; ++r) to[v[r]] = SimdVec3(rows[r]);
  }
}

template <class F>
BURNISH_INLINE void move(const ValenceOrder::Group& group, const Row* planes, float per_squared_scale,
                         const SimdVec3* from, SimdVec3* to) {
#define BURNISH_VALENCE(k) \
  case k:                  \
    return move_group<F, k>(group, planes, per_squared_scale, from, to);
  switch (group.valence) {
    BURNISH_VALENCE(3)
    BURNISH_VALENCE(4)
    BURNISH_VALENCE(5)
    BURNISH_VALENCE(6)
    BURNISH_VALENCE(7)
    BURNISH_VALENCE(8)
    BURNISH_VALENCE(9)
    BURNISH_VALENCE(10)
    default:
      return;
  }
#undef BURNISH_VALENCE
}

void expect_128(std::span<const Wings> wings, std::span<const SimdVec3> from, std::size_t begin,
                std::size_t end, std::span<Row> planes) {
  expect<F4>(wings.data(), from.data(), begin, end, planes.data());
}
void move_128(const ValenceOrder::Group& group, std::span<const Row> planes, float per_squared_scale,
              std::span<const SimdVec3> from, std::span<SimdVec3> to) {
  move<F4>(group, planes.data(), per_squared_scale, from.data(), to.data());
}
#if defined(__x86_64__)
[[gnu::target("avx2")]] void expect_256(std::span<const Wings> wings, std::span<const SimdVec3> from,
                                        std::size_t begin, std::size_t end, std::span<Row> planes) {
  expect<F8>(wings.data(), from.data(), begin, end, planes.data());
}
[[gnu::target("avx2")]] void move_256(const ValenceOrder::Group& group, std::span<const Row> planes,
                                      float per_squared_scale, std::span<const SimdVec3> from,
                                      std::span<SimdVec3> to) {
  move<F8>(group, planes.data(), per_squared_scale, from.data(), to.data());
}
#endif

}  // namespace

float exponential_coefficient(float x) {
  float d = std::min(x, kLogOfMost);
  exponential(d);
  return d;
}

std::vector<Kernels> kernels_here() {
  std::vector<Kernels> here{{128, expect_128, move_128}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) here.push_back({256, expect_256, move_256});
#endif
  return here;
}

const Kernels& kernels() {
  static const Kernels kWidest = kernels_here().back();
  return kWidest;
}

}  // namespace burnish::adaptive_kernels
