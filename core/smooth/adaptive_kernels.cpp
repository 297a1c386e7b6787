#include "core/smooth/adaptive_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

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
/// Of the same lanes, at any address of floats.
template <class F>
using Anywhere __attribute__((aligned(alignof(float)), may_alias)) = F;
/// A vector holds so many rows.
template <class F>
inline constexpr std::size_t kRowsIn = kLanesOf<F> / 4;

BURNISH_INLINE F4 lanes(const Row& row) { return row; }
BURNISH_INLINE F4 lanes(const SimdVec3& row) { return row.lanes(); }

BURNISH_INLINE void join(F4& to, const F4 (&rows)[1]) { to = rows[0]; }
BURNISH_INLINE void join(F8& to, const F4 (&rows)[2]) {
  const F8 low = __builtin_shufflevector(rows[0], rows[0], 0, 1, 2, 3, -1, -1, -1, -1);
  const F8 high = __builtin_shufflevector(rows[1], rows[1], 0, 1, 2, 3, -1, -1, -1, -1);
  to = __builtin_shufflevector(low, high, 0, 1, 2, 3, 8, 9, 10, 11);
}
template <class F>
BURNISH_INLINE void split(const F& from, F4 (&rows)[kRowsIn<F>]) {
  using Half __attribute__((may_alias)) = F4;
  for (std::size_t r = 0; r < kRowsIn<F>; ++r) rows[r] = reinterpret_cast<const Half*>(&from)[r];
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

/// One row per lane, found by every `stride`-th index.
template <class F, class Item>
BURNISH_INLINE void gather(const Item* items, const std::uint32_t* indices, std::size_t stride,
                           Columns<F>& to) {
  F* const columns[] = {&to.x, &to.y, &to.z, &to.w};
  for (std::size_t k = 0; k < 4; ++k) {
    F4 rows[kRowsIn<F>];
    for (std::size_t r = 0; r < kRowsIn<F>; ++r)
      rows[r] = lanes(at_doubled(items, indices[(k + 4 * r) * stride]));
    join(*columns[k], rows);
  }
  transpose(to.x, to.y, to.z, to.w);
}

/// The sum of `kCount` such rows per lane, found by as many indices in a row.
template <class F, std::size_t kCount, class Item>
BURNISH_INLINE void gather_sums(const Item* items, const std::uint32_t* indices, Columns<F>& to) {
  F4 sums[kLanesOf<F>];
  for (std::size_t k = 0; k < kLanesOf<F>; ++k) sums[k] = lanes(at_doubled(items, indices[k * kCount]));
#pragma GCC unroll 1
  for (std::size_t i = 1; i < kCount; ++i) {
    for (std::size_t k = 0; k < kLanesOf<F>; ++k)
      sums[k] += lanes(at_doubled(items, indices[k * kCount + i]));
  }
  F* const columns[] = {&to.x, &to.y, &to.z, &to.w};
  for (std::size_t k = 0; k < 4; ++k) {
    F4 rows[kRowsIn<F>];
    for (std::size_t r = 0; r < kRowsIn<F>; ++r) rows[r] = sums[k + 4 * r];
    join(*columns[k], rows);
  }
  transpose(to.x, to.y, to.z, to.w);
}

/// Calls put(lane, row) for each lane.
template <class F, class Put>
BURNISH_INLINE void scatter(Columns<F>& from, Put&& put) {
  transpose(from.x, from.y, from.z, from.w);
  const F* const columns[] = {&from.x, &from.y, &from.z, &from.w};
  for (std::size_t k = 0; k < 4; ++k) {
    F4 rows[kRowsIn<F>];
    split(*columns[k], rows);
    for (std::size_t r = 0; r < kRowsIn<F>; ++r) put(k + 4 * r, rows[r]);
  }
}

template <class F>
BURNISH_INLINE void measure(const std::uint32_t* corners, const SimdVec3* from, std::size_t begin,
                            std::size_t end, Row* area_normals, Row* centroids) {
  for (std::size_t f = begin; f < end; f += kLanesOf<F>) {
    Columns<F> a, b, c, normal;
    gather(from, corners + 3 * f, 3, a);
    gather(from, corners + 3 * f + 1, 3, b);
    gather(from, corners + 3 * f + 2, 3, c);
    auto* const sums = reinterpret_cast<Anywhere<F>*>(centroids + f);
    sums[0] = a.x + b.x + c.x, sums[1] = a.y + b.y + c.y, sums[2] = a.z + b.z + c.z;
    b.x -= a.x, b.y -= a.y, b.z -= a.z, c.x -= a.x, c.y -= a.y, c.z -= a.z;
    normal.x = b.y * c.z - b.z * c.y, normal.y = b.z * c.x - b.x * c.z, normal.z = b.x * c.y - b.y * c.x;
    normal.w = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    take_root(normal.w);
    scatter(normal, [&](std::size_t k, const F4& row) { area_normals[f + k] = row; });
  }
}

/// The plane of a triangle whose neighbours cancel out, or that has none: through its own normal, if it has
/// one.
Row own_plane(const Row& area_normal, float x, float y, float z) {
  if (!(area_normal[3] > 0)) return Row{};
  const Row m = area_normal * (1 / area_normal[3]);
  return Row{m[0], m[1], m[2], (m[0] * x + m[1] * y + m[2] * z) * (1.0F / 3.0F)};
}

template <class F>
BURNISH_INLINE void expect(const std::uint32_t* across, const Row* area_normals, std::size_t begin,
                           std::size_t end, Row* planes) {
  for (std::size_t f = begin; f < end; f += kLanesOf<F>) {
    Columns<F> m;
    gather_sums<F, 3>(area_normals, across + 3 * f, m);
    const auto* const sums = reinterpret_cast<const Anywhere<F>*>(planes + f);
    const F x = sums[0], y = sums[1], z = sums[2];
    const F size = m.x * m.x + m.y * m.y + m.z * m.z, least = m.w * kVanishing;
    const auto sound = size > least * least;
    const F by = 1.0F / m.w;
    m.x *= by, m.y *= by, m.z *= by;
    m.w = (m.x * x + m.y * y + m.z * z) * (1.0F / 3.0F);
    scatter(m, [&](std::size_t k, const F4& row) { planes[f + k] = row; });
    if (all_of<F>(sound)) [[likely]]
      continue;
    for (std::size_t k = 0; k < kLanesOf<F>; ++k) {
      if (sound[k] == 0) planes[f + k] = own_plane(area_normals[f + k], x[k], y[k], z[k]);
    }
  }
}

/// As many vertices as there are lanes; their neighbours and faces one vertex after the other.
template <class F, std::size_t kValence>
BURNISH_INLINE void move_some(const Index* vertices, const std::uint32_t* neighbours,
                              const std::uint32_t* faces, const Row* planes, float per_squared_scale,
                              const SimdVec3* from, SimdVec3* to) {
  constexpr float kShare = 1.0F / kValence;
  std::uint32_t places[kLanesOf<F>];
  for (std::size_t k = 0; k < kLanesOf<F>; ++k) places[k] = doubled(vertices[k]);
  Columns<F> p, u, m;
  gather(from, places, 1, p);
  F x{}, y{}, z{};
#pragma GCC unroll 1
  for (std::size_t i = 0; i < kValence; ++i) {
    gather(planes, faces + i, kValence, m);
    const F height = m.w - (m.x * p.x + m.y * p.y + m.z * p.z);
    x += m.x * height, y += m.y * height, z += m.z * height;
  }
  gather_sums<F, kValence>(from, neighbours, u);
  u.x = u.x * kShare - p.x, u.y = u.y * kShare - p.y, u.z = u.z * kShare - p.z;
  F d = (u.x * u.x + u.y * u.y + u.z * u.z) * per_squared_scale;
  d = d < kLogOfMost ? d : F{} + kLogOfMost;
  exponential(d);
  d *= kShare;
  p.x += x * d, p.y += y * d, p.z += z * d;
  scatter(p, [&](std::size_t k, const F4& row) { to[vertices[k]] = SimdVec3(row); });
}

template <class F, std::size_t kValence>
BURNISH_INLINE void move_group(const ValenceOrder::Group& group, const Row* planes, float per_squared_scale,
                               const SimdVec3* from, SimdVec3* to) {
  constexpr std::size_t kLanes = kLanesOf<F>;
  const std::size_t count = group.vertices.size();
  const Index* vertices = group.vertices.data();
  const std::uint32_t *neighbours = group.neighbours.data(), *faces = group.faces.data();
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    move_some<F, kValence>(vertices + i, neighbours + i * kValence, faces + i * kValence, planes,
                           per_squared_scale, from, to);
  }
  if (i == count) return;
  Index last[kLanes];
  std::uint32_t last_neighbours[kLanes * kValence], last_faces[kLanes * kValence];
  for (std::size_t k = 0; k < kLanes; ++k) {
    const std::size_t at = std::min(i + k, count - 1);  // the last one comes several times
    last[k] = vertices[at];
    std::copy_n(neighbours + at * kValence, kValence, last_neighbours + k * kValence);
    std::copy_n(faces + at * kValence, kValence, last_faces + k * kValence);
  }
  move_some<F, kValence>(last, last_neighbours, last_faces, planes, per_squared_scale, from, to);
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

void measure_128(std::span<const std::uint32_t> corners, std::span<const SimdVec3> from, std::size_t begin,
                 std::size_t end, std::span<Row> area_normals, std::span<Row> planes) {
  measure<F4>(corners.data(), from.data(), begin, end, area_normals.data(), planes.data());
}
void expect_128(std::span<const std::uint32_t> across, std::span<const Row> area_normals, std::size_t begin,
                std::size_t end, std::span<Row> planes) {
  expect<F4>(across.data(), area_normals.data(), begin, end, planes.data());
}
void move_128(const ValenceOrder::Group& group, std::span<const Row> planes, float per_squared_scale,
              std::span<const SimdVec3> from, std::span<SimdVec3> to) {
  move<F4>(group, planes.data(), per_squared_scale, from.data(), to.data());
}
#if defined(__x86_64__)
[[gnu::target("avx2")]] void measure_256(std::span<const std::uint32_t> corners,
                                         std::span<const SimdVec3> from, std::size_t begin, std::size_t end,
                                         std::span<Row> area_normals, std::span<Row> planes) {
  measure<F8>(corners.data(), from.data(), begin, end, area_normals.data(), planes.data());
}
[[gnu::target("avx2")]] void expect_256(std::span<const std::uint32_t> across,
                                        std::span<const Row> area_normals, std::size_t begin, std::size_t end,
                                        std::span<Row> planes) {
  expect<F8>(across.data(), area_normals.data(), begin, end, planes.data());
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
  std::vector<Kernels> here{{128, measure_128, expect_128, move_128}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) here.push_back({256, measure_256, expect_256, move_256});
#endif
  return here;
}

const Kernels& kernels() {
  static const Kernels kWidest = kernels_here().back();
  return kWidest;
}

}  // namespace burnish::adaptive_kernels
