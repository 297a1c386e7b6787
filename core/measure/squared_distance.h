// Private to the nearest-triangle search: its one formula, for a double and for vectors of them. No branch:
// what is not asked for may be NaN.
#pragma once

#include "core/mesh/vec3.h"

namespace burnish::detail {

template <class Real>
[[gnu::always_inline]] inline Real smaller(const Real& a, const Real& b) {
  return a < b ? a : b;
}

template <class Real>
[[gnu::always_inline]] inline Real dot_of(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class Real>
[[gnu::always_inline]] inline Vec3<Real> way(const Vec3<Real>& from, const Vec3<Real>& to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}

template <class Real>
[[gnu::always_inline]] inline Vec3<Real> cross_of(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// To a side, from the ways that lead from its ends to the point and from the first end to the second.
template <class Real>
[[gnu::always_inline]] inline Real squared_to_side(const Vec3<Real>& from_a, const Vec3<Real>& from_b,
                                                   const Vec3<Real>& along) {
  const Real done = dot_of(from_a, along), size = dot_of(along, along), share = done / size;
  const Vec3<Real> beside{from_a.x - along.x * share, from_a.y - along.y * share, from_a.z - along.z * share};
  const Real to_a = dot_of(from_a, from_a), to_b = dot_of(from_b, from_b), to_line = dot_of(beside, beside);
  return done <= 0 ? to_a : (done >= size ? to_b : to_line);
}

/// A point and a triangle, as the ways from the triangle's corner a to the point (p) and to its corners b and
/// c.
template <class Real>
struct Wedge {
  Vec3<Real> p, b, c;
  Real pb, pc, bb, bc, cc;  ///< their dot products

  [[gnu::always_inline]] Wedge(const Vec3<Real>& point, const Vec3<Real>& corner_a,
                               const Vec3<Real>& corner_b, const Vec3<Real>& corner_c)
      : p(way(corner_a, point)),
        b(way(corner_a, corner_b)),
        c(way(corner_a, corner_c)),
        pb(dot_of(p, b)),
        pc(dot_of(p, c)),
        bb(dot_of(b, b)),
        bc(dot_of(b, c)),
        cc(dot_of(c, c)) {}

  /// So flat, or so much a point or a line, that rounding tells in the products above.
  [[gnu::always_inline]] auto is_flat() const { return !(bb * cc - bc * bc > 1e-6 * (bb * cc)); }

  /// For flat triangles: the face by its normal, and each side for itself.
  [[gnu::always_inline]] Real squared_to_flat() const {
    const Vec3<Real> from_b = way(b, p), from_c = way(c, p), bc_side = way(b, c),
                     ca_side = way(c, Vec3<Real>{});
    const Vec3<Real> normal = cross_of(b, c);
    const Real size = dot_of(normal, normal), height = dot_of(p, normal);
    const Real outermost =
        smaller(smaller(dot_of(cross_of(b, p), normal), dot_of(cross_of(bc_side, from_b), normal)),
                dot_of(cross_of(ca_side, from_c), normal));
    const Real to_sides = smaller(smaller(squared_to_side(p, from_b, b), squared_to_side(p, from_c, c)),
                                  squared_to_side(from_b, from_c, bc_side));
    return ((size > 0) & (outermost >= 0)) ? height * height / size : to_sides;
  }

  /// For all others. The nearest point is a + v b + w c, by the region that the point is over: a corner, a
  /// side or the face (Ericson, Real-Time Collision Detection, 5.1.5).
  [[gnu::always_inline]] Real squared_to_face() const {
    const Real zero = bb - bb, one = zero + 1;
    const Real b_b = pb - bb, b_c = pc - bc, c_b = pb - bc, c_c = pc - cc;  // from the corners b and c
    const Real over_a = b_b * c_c - c_b * b_c, over_b = c_b * pc - pb * c_c, over_c = pb * b_c - b_b * pc;
    const Real up = b_c - b_b, down = c_b - c_c;  // along the side from b to c
    Real v = over_b, w = over_c, all = over_a + over_b + over_c;
    const auto choose = [&](const auto& here, const Real& v_here, const Real& w_here, const Real& all_here)
        __attribute__((always_inline)) {
      v = here ? v_here : v;
      w = here ? w_here : w;
      all = here ? all_here : all;
    };
    choose((over_a <= 0) & (up >= 0) & (down >= 0), down, up, up + down);
    choose((over_b <= 0) & (pc >= 0) & (c_c <= 0), zero, pc, pc - c_c);
    choose((over_c <= 0) & (pb >= 0) & (b_b <= 0), pb, zero, pb - b_b);
    choose((c_c >= 0) & (c_b <= c_c), zero, one, one);
    choose((b_b >= 0) & (b_c <= b_b), one, zero, one);
    choose((pb <= 0) & (pc <= 0), zero, zero, one);
    v = v / all;
    w = w / all;
    const Vec3<Real> rest{p.x - b.x * v - c.x * w, p.y - b.y * v - c.y * w, p.z - b.z * v - c.z * w};
    return dot_of(rest, rest);
  }
};

}  // namespace burnish::detail
