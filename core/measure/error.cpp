#include "core/measure/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/measure/nearest.h"
#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// The reference's positions in the frame of the result.
std::vector<Vec3f> into_frame(const Frame& frame, const Surface& reference, std::span<const Vec3f> positions,
                              const RunControl& run) {
  std::vector<Vec3f> local(positions.begin(), positions.end());
  const Frame& own = reference.mesh.frame;
  if (own.centre == frame.centre && own.exponent == frame.exponent) return local;
  parallel_for(local.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      Vec3d p = own.to_file(to_double(positions[v])) - frame.centre;
      // A reference from another world stays within reach: its distance is huge either way.
      constexpr double kFar = NearestTriangle::kFarthest;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        p[axis] = std::clamp(std::ldexp(p[axis], -frame.exponent), -kFar, kFar);
      }
      local[v] = to_float(p);
    }
  });
  return local;
}

/// For each vertex of the surface the reference's vertex that comes from the same file vertex.
std::vector<Index> partners(const Surface& surface, const Surface& reference) {
  std::vector<Index> partner(surface.mesh.positions.size(), kNone);
  for (std::size_t v = surface.weld.size(); v-- > 0;) partner[surface.weld[v]] = reference.weld[v];
  return partner;
}

Vec3d area_normal(std::span<const Vec3f> positions, const Triangle& t) {
  const Vec3d a = to_double(positions[t[0]]);
  return cross(to_double(positions[t[1]]) - a, to_double(positions[t[2]]) - a);
}

double diagonal(std::span<const Vec3f> positions) {
  Vec3f low = positions.front(), high = low;
  for (const Vec3f& p : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  return length(to_double(high) - to_double(low));
}

double ratio(double value, double by) { return by > 0 ? value / by : 0; }

bool measure_distances(const Surface& surface, std::span<const Vec3f> positions,
                       const NearestTriangle& nearest, const RunControl& run, std::vector<double>& squared) {
  squared.assign(positions.size(), 0);
  return parallel_for(positions.size(), run, [&](std::size_t begin, std::size_t end) {
    Index near = 0;
    for (std::size_t v = begin; v < end; ++v) {
      if (v % 4 == 0 && run.stopped()) return;  // triangles that overlap make a query slow
      if (surface.topology.vertex_faces[v].empty()) continue;
      const auto hit = nearest.find(positions[v], near);
      squared[v] = hit.squared_distance;
      near = hit.triangle;
    }
  });
}

/// The same when the reference's vertex `partner[v]` is known: it is rarely far, and unless it is in no
/// triangle its distance bounds the search.
bool measure_near_distances(const Surface& surface, std::span<const Vec3f> positions,
                            const NearestTriangle& nearest, const Surface& reference,
                            std::span<const Vec3f> others, std::span<const Index> partner,
                            const RunControl& run, std::vector<double>& squared) {
  squared.assign(positions.size(), 0);
  const double wide = 4 * surface.mean_edge;
  return parallel_for(positions.size(), run, [&](std::size_t begin, std::size_t end) {
    std::array<Vec3f, NearestTriangle::kGroup> points;
    std::array<double, NearestTriangle::kGroup> bounds;
    std::array<std::size_t, NearestTriangle::kGroup> vertices;
    Index near = 0;
    for (std::size_t v = begin; v < end;) {
      if (run.stopped()) return;
      std::size_t count = 0;
      for (; v < end && count < points.size(); ++v) {
        if (surface.topology.vertex_faces[v].empty()) continue;
        if (count > 0 && length(to_double(positions[v] - points[0])) > wide) break;
        const Vec3d way = to_double(positions[v]) - to_double(others[partner[v]]);
        const auto faces = reference.topology.vertex_faces[partner[v]];
        const bool bounded = !faces.empty();
        if (bounded) near = faces.front();
        points[count] = positions[v];
        bounds[count] = bounded ? dot(way, way) : std::numeric_limits<double>::infinity();
        vertices[count++] = v;
      }
      nearest.find_all(std::span(points).first(count), std::span(bounds).first(count), near, run);
      for (std::size_t i = 0; i < count; ++i) squared[vertices[i]] = bounds[i];
    }
  });
}

/// Eq. 9 and the plain means.
bool summarise_distances(const Surface& surface, std::span<const Vec3f> positions,
                         std::span<const double> squared, const RunControl& run, ErrorMeasures& measures) {
  const auto& triangles = surface.mesh.triangles;
  std::vector<double> areas(triangles.size());
  const auto over_vertices = [&](auto&& term) {
    return parallel_sum(positions.size(), run, [&](std::size_t begin, std::size_t end) {
      double sum = 0;
      for (std::size_t v = begin; v < end; ++v) sum += term(v);
      return sum;
    });
  };
  const double area = parallel_sum(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t t = begin; t < end; ++t)
      sum += areas[t] = length(area_normal(positions, triangles[t])) / 2;
    return sum;
  });
  const double weighted = over_vertices([&](std::size_t v) {
    double at_vertex = 0;
    for (const Index f : surface.topology.vertex_faces[v]) at_vertex += areas[f];
    return at_vertex * squared[v];
  });
  const double count = static_cast<double>(positions.size() - surface.topology.isolated_vertices);
  measures.ev = std::sqrt(ratio(weighted, 3 * area));
  measures.mean_distance = ratio(over_vertices([&](std::size_t v) { return std::sqrt(squared[v]); }), count);
  measures.rms_distance = std::sqrt(ratio(over_vertices([&](std::size_t v) { return squared[v]; }), count));
  measures.max_distance = std::sqrt(*std::max_element(squared.begin(), squared.end()));
  return !run.stopped();
}

bool compare_normals(const Surface& surface, std::span<const Vec3f> positions, std::span<const Vec3f> others,
                     std::span<const Index> partner, const RunControl& run, ErrorMeasures& measures) {
  const auto& triangles = surface.mesh.triangles;
  std::vector<double> angles(triangles.size(), -1);  // -1: no normal to compare
  const bool done = parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Triangle& corners = triangles[t];
      const Vec3d ours = area_normal(positions, corners);
      const Vec3d theirs =
          area_normal(others, {partner[corners[0]], partner[corners[1]], partner[corners[2]]});
      if (dot(ours, ours) == 0 || dot(theirs, theirs) == 0) continue;
      angles[t] = portable_angle(length(cross(ours, theirs)), dot(ours, theirs)) * kDegreesPerRadian;
    }
  });
  double sum = 0, largest = 0;
  std::uint32_t compared = 0, flipped = 0;
  for (const double angle : angles) {
    if (angle < 0) continue;
    sum += angle;
    largest = std::max(largest, angle);
    ++compared;
    flipped += angle > 90;
  }
  measures.mean_normal_degrees = ratio(sum, compared);
  measures.max_normal_degrees = largest;
  measures.flipped_triangles = flipped;
  return done;
}

}  // namespace

Result<ErrorMeasures> measure_errors(const Surface& surface, std::span<const Vec3f> positions,
                                     const Surface& reference, std::span<const Vec3f> reference_positions,
                                     bool corresponding, const RunControl& run) {
  ErrorMeasures measures;
  const auto local = into_frame(surface.mesh.frame, reference, reference_positions, run);
  const auto partner = corresponding ? partners(surface, reference) : std::vector<Index>();
  if (!surface.mesh.triangles.empty() && !reference.mesh.triangles.empty()) {
    auto nearest = NearestTriangle::build(local, reference.mesh.triangles, run);
    if (!nearest) return nearest.error();
    std::vector<double> squared;
    const bool measured = corresponding ? measure_near_distances(surface, positions, *nearest, reference,
                                                                 local, partner, run, squared)
                                        : measure_distances(surface, positions, *nearest, run, squared);
    if (!measured || !summarise_distances(surface, positions, squared, run, measures)) {
      return run.stop_error();
    }
  }
  if (corresponding && !compare_normals(surface, positions, local, partner, run, measures))
    return run.stop_error();
  const double edge = reference.mean_edge * reference.mesh.frame.scale() / surface.mesh.frame.scale();
  measures.ev_over_edge = ratio(measures.ev, edge);
  measures.ev_over_diagonal = ratio(measures.ev, diagonal(local));
  for (double* in_local_units :
       {&measures.ev, &measures.mean_distance, &measures.rms_distance, &measures.max_distance}) {
    *in_local_units *= surface.mesh.frame.scale();
  }
  return measures;
}

}  // namespace burnish
