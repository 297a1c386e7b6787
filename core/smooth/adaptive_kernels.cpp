#include "core/smooth/adaptive_kernels.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <utility>

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
using F16 = Floats<16>;

template <class F>
inline constexpr std::size_t kLanesOf = sizeof(F) / sizeof(float);
/// A vector holds so many rows.
template <class F>
inline constexpr std::size_t kRowsIn = kLanesOf<F> / 4;

BURNISH_INLINE void join(F4& to, const F4 (&rows)[1]) { to = rows[0]; }
// Widened before they are put together: GCC goes by way of the memory otherwise.
BURNISH_INLINE void join(F8& to, const F4 (&rows)[2]) {
  const F8 low = __builtin_shufflevector(rows[0], rows[0], 0, 1, 2, 3, -1, -1, -1, -1);
  const F8 high = __builtin_shufflevector(rows[1], rows[1], 0, 1, 2, 3, -1, -1, -1, -1);
  to = __builtin_shufflevector(low, high, 0, 1, 2, 3, 8, 9, 10, 11);
}
BURNISH_INLINE void join(F16& to, const F4 (&rows)[4]) {
  F8 one, two;
  join(one, {rows[0], rows[1]});
  join(two, {rows[2], rows[3]});
  const F16 low = __builtin_shufflevector(one, one, 0, 1, 2, 3, 4, 5, 6, 7, -1, -1, -1, -1, -1, -1, -1, -1);
  const F16 high = __builtin_shufflevector(two, two, 0, 1, 2, 3, 4, 5, 6, 7, -1, -1, -1, -1, -1, -1, -1, -1);
  to = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
}
template <class F>
BURNISH_INLINE void split(const F& from, F4 (&rows)[kRowsIn<F>]) {
  using Half __attribute__((may_alias)) = F4;
  for (std::size_t r = 0; r < kRowsIn<F>; ++r) rows[r] = reinterpret_cast<const Half*>(&from)[r];
}

template <class F>
BURNISH_INLINE void take_root(F& a) {
  for (std::size_t k = 0; k < kLanesOf<F>; ++k) a[k] = std::sqrt(a[k]);
}
#if defined(__x86_64__)
BURNISH_INLINE void take_root(F4& a) { a = _mm_sqrt_ps(a); }
#if !defined(__clang__)
// GCC takes no intrinsic of AVX into a function that is not compiled for it, as these templates are; in
// quarters the roots cost a twentieth of the whole.
BURNISH_INLINE void take_root(F8& a) { asm("vsqrtps %1, %0" : "=x"(a) : "x"(a)); }
BURNISH_INLINE void take_root(F16& a) { asm("vsqrtps %1, %0" : "=v"(a) : "v"(a)); }
#endif
#endif

template <int k1, int k2, int k3, int k4>
constexpr int picked_lane(int lane, int lanes) {
  constexpr int kPicked[] = {k1, k2, k3, k4};
  const int k = kPicked[lane % 4], row = lane / 4 * 4;
  return k < 4 ? row + k : lanes + row + k - 4;
}
/// Lanes k1 to k4 of each row, in which 4 and more count the lanes of the other vector's row.
template <int k1, int k2, int k3, int k4, class F>
BURNISH_INLINE void pick(const F& a, const F& b, F& to) {
  [&]<int... kLane>(std::integer_sequence<int, kLane...>) __attribute__((always_inline)) {
    to = __builtin_shufflevector(a, b, picked_lane<k1, k2, k3, k4>(kLane, kLanesOf<F>)...);
  }
  (std::make_integer_sequence<int, kLanesOf<F>>{});
}
/// Columns of four lanes to rows, or back.
template <class F>
BURNISH_INLINE void transpose(F& a, F& b, F& c, F& d) {
  F ab, ab_high, cd, cd_high;
  pick<0, 1, 4, 5>(a, b, ab);
  pick<2, 3, 6, 7>(a, b, ab_high);
  pick<0, 1, 4, 5>(c, d, cd);
  pick<2, 3, 6, 7>(c, d, cd_high);
  pick<0, 2, 4, 6>(ab, cd, a);
  pick<1, 3, 5, 7>(ab, cd, b);
  pick<0, 2, 4, 6>(ab_high, cd_high, c);
  pick<1, 3, 5, 7>(ab_high, cd_high, d);
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

/// One point per lane, found by every `stride`-th index.
template <class F>
BURNISH_INLINE void gather(const SimdVec3* points, const std::uint32_t* indices, std::size_t stride,
                           Columns<F>& to) {
  F* const columns[] = {&to.x, &to.y, &to.z, &to.w};
  for (std::size_t k = 0; k < 4; ++k) {
    F4 rows[kRowsIn<F>];
    for (std::size_t r = 0; r < kRowsIn<F>; ++r)
      rows[r] = at_doubled(points, indices[(k + 4 * r) * stride]).lanes();
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

/// What the triangles at a vertex are made of, per lane: the way to a neighbour, and (n, |n|) of the triangle
/// between that and the neighbour before, n the normal times twice the area.
template <class F>
struct Spoke {
  F x, y, z, nx, ny, nz, nw;
};

/// (n, |n|) of the triangle with these two ways from its first corner.
template <class F>
BURNISH_INLINE void area_normal(const F& ax, const F& ay, const F& az, const F& bx, const F& by, const F& bz,
                                F& x, F& y, F& z, F& size) {
  x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
  size = x * x + y * y + z * z;
  take_root(size);
}

/// As many vertices as there are lanes; their rings one vertex after the other.
template <class F, std::size_t kValence>
BURNISH_INLINE void move_some(const Index* vertices, const std::uint32_t* ring, const std::uint32_t* beyond,
                              bool only_offset, float per_squared_scale, const SimdVec3* from, SimdVec3* to) {
  constexpr float kShare = 1.0F / kValence;
  std::uint32_t places[kLanesOf<F>];
  for (std::size_t k = 0; k < kLanesOf<F>; ++k) places[k] = doubled(vertices[k]);
  Columns<F> p, r;
  gather(from, places, 1, p);

  // Triangle i lies between spokes i and i + 1, its normal is with the latter; the first comes again as the
  // last.
  Spoke<F> spokes[kValence + 1];
  Spoke<F>&first = spokes[0], &last = spokes[kValence];
  gather(from, ring, kValence, r);
  F x = r.x - p.x, y = r.y - p.y, z = r.z - p.z;
  F ux = x, uy = y, uz = z;
  first.x = last.x = x, first.y = last.y = y, first.z = last.z = z;
#pragma GCC unroll 1
  for (std::size_t i = 1; i < kValence; ++i) {
    Spoke<F>& spoke = spokes[i];
    gather(from, ring + i, kValence, r);
    const F ax = x, ay = y, az = z;
    x = r.x - p.x, y = r.y - p.y, z = r.z - p.z;
    spoke.x = x, spoke.y = y, spoke.z = z;
    ux += x, uy += y, uz += z;
    area_normal(ax, ay, az, x, y, z, spoke.nx, spoke.ny, spoke.nz, spoke.nw);
  }
  area_normal(x, y, z, last.x, last.y, last.z, last.nx, last.ny, last.nz, last.nw);
  first.nx = last.nx, first.ny = last.ny, first.nz = last.nz, first.nw = last.nw;

  F vx{}, vy{}, vz{};
  const auto add_offset = [&](std::size_t i, const Spoke<F>& after) __attribute__((always_inline)) {
    // Or GCC keeps what one step leaves for the next, for which 16 registers are too few.
    asm("" : "+m"(spokes));
    const Spoke<F>&a = spokes[i], &b = spokes[i + 1];
    gather(from, beyond + i, kValence, r);
    const F bx = b.x, by = b.y, bz = b.z;
    F mx, my, mz, areas;  // the sum of Eq. 1, and that of its weights
    area_normal<F>(r.x - p.x - a.x, r.y - p.y - a.y, r.z - p.z - a.z, bx - a.x, by - a.y, bz - a.z, mx, my,
                   mz, areas);
    mx += a.nx, my += a.ny, mz += a.nz, areas += a.nw;
    mx += after.nx, my += after.ny, mz += after.nz, areas += after.nw;
    // [vC . m] m without the third of C; areas of 0 must not make 0 / 0.
    const F height =
        (mx * (a.x + bx) + my * (a.y + by) + mz * (a.z + bz)) * (1.0F / (areas * areas + FLT_MIN));
    vx += mx * height, vy += my * height, vz += mz * height;
  };
#pragma GCC unroll 1
  for (std::size_t i = 0; i + 1 < kValence; ++i) add_offset(i, spokes[i + 2]);
  add_offset(kValence - 1, spokes[1]);

  F d = F{} + 1.0F;
  if (only_offset) {
    p.x = p.y = p.z = F{};
  } else {
    ux *= kShare, uy *= kShare, uz *= kShare;
    d = (ux * ux + uy * uy + uz * uz) * per_squared_scale;
    d = d < kLogOfMost ? d : F{} + kLogOfMost;
    exponential(d);
  }
  d *= kShare * (1.0F / 3.0F);
  p.x += vx * d, p.y += vy * d, p.z += vz * d;
  scatter(p, [&](std::size_t k, const F4& row) { at_doubled(to, places[k]) = SimdVec3(row); });
}

template <class F, std::size_t kValence>
BURNISH_INLINE void move_group(const Index* vertices, std::size_t count, const std::uint32_t* neighbours,
                               const std::uint32_t* beyond, bool only_offset, float per_squared_scale,
                               const SimdVec3* from, SimdVec3* to) {
  constexpr std::size_t kLanes = kLanesOf<F>;
  for (; count >= kLanes; count -= kLanes, vertices += kLanes) {
    move_some<F, kValence>(vertices, neighbours, beyond, only_offset, per_squared_scale, from, to);
    neighbours += kLanes * kValence, beyond += kLanes * kValence;
  }
  if (count == 0) return;
  if constexpr (kLanes > 4) {
    if (count <= kLanes / 2) {  // lanes that do the same twice cost as much
      move_group<Floats<kLanes / 2>, kValence>(vertices, count, neighbours, beyond, only_offset,
                                               per_squared_scale, from, to);
      return;
    }
  }
  Index last[kLanes];
  std::uint32_t last_neighbours[kLanes * kValence], last_beyond[kLanes * kValence];
  for (std::size_t k = 0; k < kLanes; ++k) {
    const std::size_t at = std::min(k, count - 1);  // the last one comes several times
    last[k] = vertices[at];
    std::copy_n(neighbours + at * kValence, kValence, last_neighbours + k * kValence);
    std::copy_n(beyond + at * kValence, kValence, last_beyond + k * kValence);
  }
  move_some<F, kValence>(last, last_neighbours, last_beyond, only_offset, per_squared_scale, from, to);
}

template <class F>
BURNISH_INLINE void move(const ValenceOrder::Group& group, bool only_offset, float per_squared_scale,
                         const SimdVec3* from, SimdVec3* to) {
#define BURNISH_VALENCE(k)                                                                         \
  case k:                                                                                          \
    return move_group<F, k>(group.vertices.data(), group.vertices.size(), group.neighbours.data(), \
                            group.beyond.data(), only_offset, per_squared_scale, from, to);
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

void move_128(const ValenceOrder::Group& group, bool only_offset, float per_squared_scale,
              std::span<const SimdVec3> from, std::span<SimdVec3> to) {
  move<F4>(group, only_offset, per_squared_scale, from.data(), to.data());
}
#if defined(__x86_64__)
[[gnu::target("avx2")]] void move_256(const ValenceOrder::Group& group, bool only_offset,
                                      float per_squared_scale, std::span<const SimdVec3> from,
                                      std::span<SimdVec3> to) {
  move<F8>(group, only_offset, per_squared_scale, from.data(), to.data());
}
[[gnu::target("avx512f,avx512dq,avx512vl")]] void move_512(const ValenceOrder::Group& group, bool only_offset,
                                                           float per_squared_scale,
                                                           std::span<const SimdVec3> from,
                                                           std::span<SimdVec3> to) {
  move<F16>(group, only_offset, per_squared_scale, from.data(), to.data());
}
#endif

}  // namespace

float exponential_coefficient(float x) {
  float d = std::min(x, kLogOfMost);
  exponential(d);
  return d;
}

std::vector<Kernel> kernels_here() {
  std::vector<Kernel> here{{128, move_128}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) here.push_back({256, move_256});
  // From Ice Lake and Zen 4 on: before them vectors of 512 bits slow the clock.
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vbmi2");
  if (wide) here.push_back({512, move_512});
#endif
  return here;
}

const Kernel& kernel() {
  static const Kernel kWidest = kernels_here().back();
  return kWidest;
}

}  // namespace burnish::adaptive_kernels
