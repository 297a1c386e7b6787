#include "core/measure/error.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "core/measure/nearest.h"
#include "core/measure/triangle_sums.h"
#include "core/mesh/simd_vec3.h"
#include "core/run/buffer.h"
#include "core/run/math.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// The reference's positions in the frame of the result.
Buffer<Vec3f> into_frame(const Frame& frame, const Surface& reference, std::span<const Vec3f> positions,
                         const RunControl& run) {
  Buffer<Vec3f> local(positions.size());
  const Frame& own = reference.mesh.frame;
  // Powers of two: products with them round as ldexp does.
  const double scale = own.scale(), shrink = 1 / frame.scale();
  parallel_for(local.size(), run, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      Vec3d p = (own.centre + to_double(positions[v]) * scale) - frame.centre;
      // A reference from another world stays within reach: its distance is huge either way.
      constexpr double kFar = NearestTriangle::kFarthest;
      for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = std::clamp(p[axis] * shrink, -kFar, kFar);
      local[v] = to_float(p);
    }
  });
  return local;
}

/// For each vertex of the surface the reference's vertex that comes from the same file vertex, the first of
/// them when several were welded.
std::vector<Index> partners(const Surface& surface, const Surface& reference, const RunControl& run) {
  std::vector<Index> partner(surface.mesh.positions.size(), kNone);
  const auto join = [&](std::size_t v) { partner[surface.weld[v]] = reference.weld[v]; };
  if (surface.welded_vertices == 0) {
    for_each(surface.weld.size(), run, join);
    return partner;
  }
  for (std::size_t v = surface.weld.size(); v-- > 0;) {
    if (v % kBlockSize == 0 && run.stopped()) break;
    join(v);
  }
  return partner;
}

bool counts_up(std::span<const Index> indices, const RunControl& run) {
  std::atomic<bool> so_far = true;
  parallel_for(indices.size(), run, [&](std::size_t begin, std::size_t end) {
    Index jumps = 0;
    for (std::size_t i = begin; i < end; ++i) jumps |= indices[i] ^ static_cast<Index>(i);
    if (jumps != 0) so_far.store(false, std::memory_order_relaxed);
  });
  return so_far.load();
}

double diagonal(std::span<const Vec3f> positions) {
  auto low = SimdVec3(positions.front()).lanes(), high = low;
  for (const Vec3f& position : positions) {
    const auto p = SimdVec3(position).lanes();
    low = p < low ? p : low;
    high = p > high ? p : high;
  }
  return length(to_double(SimdVec3(high).vec3()) - to_double(SimdVec3(low).vec3()));
}

double ratio(double value, double by) { return by > 0 ? value / by : 0; }

bool measure_distances(const Surface& surface, std::span<const Vec3f> positions,
                       const NearestTriangle& nearest, const RunControl& run, std::span<double> squared) {
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
                            const RunControl& run, std::span<double> squared) {
  const double wide = 100 * surface.mean_edge * surface.mean_edge;
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
        const Vec3d along = count > 0 ? to_double(positions[v]) - to_double(points[0]) : Vec3d{};
        if (dot(along, along) > wide) break;
        const Vec3d way = to_double(positions[v]) - to_double(others[v]);
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

/// The reference as the measures need it; nothing is copied that need not be.
struct Other {
  Other(const Surface& surface, const Surface& of, std::span<const Vec3f> at, bool corresponding,
        const RunControl& run)
      : reference(of), positions(at) {
    const Frame &frame = surface.mesh.frame, &own = of.mesh.frame;
    if (own.centre != frame.centre || own.exponent != frame.exponent) {
      moved = into_frame(frame, of, at, run);
      positions = moved;
    }
    if (!corresponding) return;
    partner = partners(surface, of, run);
    partners_at = positions;
    if (partner.size() == positions.size() && counts_up(partner, run)) return;
    ordered.resize(partner.size());
    for_each(partner.size(), run, [&](std::size_t v) { ordered[v] = positions[partner[v]]; });
    partners_at = ordered;
  }
  Other(const Other&) = delete;  // its spans are into itself

  const Surface& reference;
  std::span<const Vec3f> positions;    // in the frame of the result
  std::vector<Index> partner;          // empty: nothing corresponds
  std::span<const Vec3f> partners_at;  // in the order of the result's vertices

 private:
  Buffer<Vec3f> moved, ordered;
};

/// Of each vertex to the nearest point of the reference; 0 where there is no triangle to ask.
Result<std::vector<double>> squared_distances(const Surface& surface, std::span<const Vec3f> positions,
                                              const Other& other, const RunControl& run) {
  if (run.stopped()) return run.stop_error();
  std::vector<double> squared(positions.size(), 0);
  const auto& triangles = other.reference.mesh.triangles;
  if (surface.mesh.triangles.empty() || triangles.empty()) return squared;
  auto nearest = NearestTriangle::build(other.positions, triangles, run);
  if (!nearest) return nearest.error();
  const bool measured = other.partner.empty()
                            ? measure_distances(surface, positions, *nearest, run, squared)
                            : measure_near_distances(surface, positions, *nearest, other.reference,
                                                     other.partners_at, other.partner, run, squared);
  if (!measured) return run.stop_error();
  return squared;
}

/// The plain means.
void summarise_distances(const Surface& surface, std::span<const double> squared, const RunControl& run,
                         ErrorMeasures& measures) {
  struct Block {
    double distances = 0, squares = 0, largest = 0;
  };
  std::vector<Block> blocks(block_count(squared.size()));
  parallel_for(squared.size(), run, [&](std::size_t begin, std::size_t end) {
    Block block;
    for (std::size_t v = begin; v < end; ++v) {
      block.distances += std::sqrt(squared[v]);
      block.squares += squared[v];
      block.largest = std::max(block.largest, squared[v]);
    }
    blocks[begin / block_size(squared.size())] = block;
  });
  Block all;
  for (const Block& block : blocks) {
    all.distances += block.distances;
    all.squares += block.squares;
    all.largest = std::max(all.largest, block.largest);
  }
  const double count = static_cast<double>(squared.size() - surface.topology.isolated_vertices);
  measures.mean_distance = ratio(all.distances, count);
  measures.rms_distance = std::sqrt(ratio(all.squares, count));
  measures.max_distance = std::sqrt(all.largest);
}

/// Eq. 9, the sum over vertices taken by triangles, and with `others` the normals.
void summarise_triangles(const Surface& surface, std::span<const Vec3f> positions,
                         std::span<const double> squared, std::span<const Vec3f> others,
                         const RunControl& run, ErrorMeasures& measures) {
  const std::span triangles(surface.mesh.triangles);
  std::vector<triangle_sums::Errors> blocks(block_count(triangles.size()));
  parallel_for(triangles.size(), run, [&](std::size_t begin, std::size_t end) {
    blocks[begin / block_size(triangles.size())] =
        triangle_sums::functions().errors(triangles.subspan(begin, end - begin), positions, squared, others);
  });
  triangle_sums::Errors all;
  for (const auto& block : blocks) {
    all.area += block.area;
    all.weighted += block.weighted;
    all.angles += block.angles;
    all.largest_angle = std::max(all.largest_angle, block.largest_angle);
    all.compared += block.compared;
    all.flipped += block.flipped;
  }
  measures.ev = std::sqrt(ratio(all.weighted, 3 * all.area));
  if (others.empty()) return;
  measures.mean_normal_degrees = ratio(all.angles, all.compared) * kDegreesPerRadian;
  measures.max_normal_degrees = all.largest_angle * kDegreesPerRadian;
  measures.flipped_triangles = all.flipped;
}

}  // namespace

Result<ErrorMeasures> measure_errors(const Surface& surface, std::span<const Vec3f> positions,
                                     const Surface& reference, std::span<const Vec3f> reference_positions,
                                     bool corresponding, const RunControl& run) {
  ErrorMeasures measures;
  const Other other(surface, reference, reference_positions, corresponding, run);
  const auto squared = squared_distances(surface, positions, other, run);
  if (!squared) return squared.error();
  summarise_distances(surface, *squared, run, measures);
  summarise_triangles(surface, positions, *squared, other.partners_at, run, measures);
  if (run.stopped()) return run.stop_error();
  const double edge = reference.mean_edge * reference.mesh.frame.scale() / surface.mesh.frame.scale();
  measures.ev_over_edge = ratio(measures.ev, edge);
  measures.ev_over_diagonal = ratio(measures.ev, diagonal(other.positions));
  for (double* in_local_units :
       {&measures.ev, &measures.mean_distance, &measures.rms_distance, &measures.max_distance}) {
    *in_local_units *= surface.mesh.frame.scale();
  }
  return measures;
}

Result<std::vector<double>> vertex_distances(const Surface& surface, std::span<const Vec3f> positions,
                                             const Surface& reference,
                                             std::span<const Vec3f> reference_positions, bool corresponding,
                                             const RunControl& run) {
  const Other other(surface, reference, reference_positions, corresponding, run);
  auto distances = squared_distances(surface, positions, other, run);
  if (!distances) return distances;
  const double scale = surface.mesh.frame.scale();
  for_each(distances->size(), run,
           [&](std::size_t v) { (*distances)[v] = std::sqrt((*distances)[v]) * scale; });
  if (run.stopped()) return run.stop_error();
  return distances;
}

}  // namespace burnish
