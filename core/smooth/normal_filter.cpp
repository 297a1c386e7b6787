#include "core/smooth/normal_filter.h"

#include "core/smooth/parameters.h"

namespace burnish {
namespace {

/// 1 or -1 per triangle, so that triangles across an edge agree wherever the surface allows; the greater part
/// of what edges connect keeps its side.
std::vector<float> orientations(const Surface& surface, const RunControl& run) {
  const Topology& topology = surface.topology;
  if (topology.opposed_edges == 0) return {};
  const std::size_t faces = surface.mesh.triangles.size();
  std::vector<float> orientation(faces);  // 0: not reached yet
  std::vector<Index> part;
  for (std::size_t seed = 0; seed < faces && !run.stopped(); ++seed) {
    if (orientation[seed] != 0) continue;
    part.assign(1, static_cast<Index>(seed));
    orientation[seed] = 1;
    double balance = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (i % kBlockSize == 0 && run.stopped()) return orientation;
      const Index f = part[i];
      balance += orientation[f];
      for (std::size_t side = 0; side < 3; ++side) {
        const Index across = topology.face_neighbours[f][side];
        if (across == kNone || orientation[across] != 0) continue;
        orientation[across] = topology.opposed(f, side) ? -orientation[f] : orientation[f];
        part.push_back(across);
      }
    }
    if (balance < 0) {
      for (const Index f : part) orientation[f] = -orientation[f];
    }
  }
  return orientation;
}

}  // namespace

Faces::Faces(const Surface& surface, FaceNeighbourhood neighbourhood, const RunControl& run)
    : surface_(surface),
      neighbourhood_(neighbourhood),
      run_(run),
      around_(surface, run),
      orientation_(orientations(surface, run)),
      normals_(surface.mesh.triangles.size()),
      next_normals_(normals_.size()),
      twice_areas_(normals_.size()) {}

bool Faces::measure(std::span<const SimdVec3> positions) {
  centroids_.resize(size());
  return for_each_block([&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const Measured face = measured(positions, f);
      normals_[f] = face.normal;
      twice_areas_[f] = face.twice_area;
      centroids_[f] = face.centroid;
    }
  });
}

bool Faces::measure_centroids(std::span<const SimdVec3> positions) {
  centroids_.resize(size());
  return for_each_block([&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) centroids_[f] = centroid_of(positions, f);
  });
}

SimdVec3 Faces::mean_of_neighbours(std::size_t f) const {
  SimdVec3 sum;
  float areas = 0;
  for_each_neighbour(f, [&](Index n) {
    sum += normals_[n] * twice_areas_[n];
    areas += twice_areas_[n];
  });
  return unit_or(sum, areas, normals_[f]);
}

double Faces::mean_centroid_distance() const {
  const Topology& topology = surface_.topology;
  const double sum = parallel_sum(size(), run_, [&](std::size_t begin, std::size_t end) {
    double part = 0;
    for (std::size_t f = begin; f < end; ++f) {
      for (const Index across : topology.face_neighbours[f]) {
        if (across != kNone && across > f)
          part += static_cast<double>(length(centroids_[across] - centroids_[f]));
      }
    }
    return part;
  });
  return topology.adjacent_pairs() > 0 ? sum / topology.adjacent_pairs() : 0;
}

Result<SmoothOutcome> iterate_normals(Surface& surface, Faces& faces, const Constraints& constraints,
                                      const IterationOptions& options, const NormalPasses& passes) {
  // The last vertex step of an iteration is iterate()'s own; the earlier ones go back and forth in here.
  std::vector<SimdVec3> steps[2];
  std::span<const SimdVec3> last;
  const auto prepare = [&](std::span<const SimdVec3> from) {
    if (!passes.filter(from)) return false;
    last = from;
    for (std::uint32_t step = 1; step < passes.vertex_steps; ++step) {
      if (passes.before_move && !passes.before_move(last)) return false;
      std::vector<SimdVec3>& to = steps[step % 2];
      if (to.empty()) to.assign(from.begin(), from.end());
      const bool done = parallel_for(last.size(), faces.run(), [&](std::size_t begin, std::size_t end) {
        passes.move(last, to, begin, end);
        constraints.enforce(to, begin, end);  // what diverges here still does so at the iteration's end
      });
      if (!done) return false;
      last = to;
      if (!faces.measure_centroids(last)) return false;
    }
    return !passes.before_move || passes.before_move(last);
  };
  return iterate(surface, constraints, options, faces.run(),
                 {.prepare = prepare, .move = [&](auto, auto to, std::size_t begin, std::size_t end) {
                    passes.move(last, to, begin, end);
                  }});
}

ParameterSpec neighbourhood_parameter(FaceNeighbourhood standard) {
  std::vector<std::string> choices = {"edges", "vertices"};
  if (standard == FaceNeighbourhood::Vertices) std::swap(choices[0], choices[1]);
  return choice_parameter("neighbourhood", std::move(choices),
                          "Neighbours of a triangle: those across its edges, or all that share a vertex.");
}

FaceNeighbourhood neighbourhood_of(const ParameterValues& values) {
  return values.choice("neighbourhood") == "edges" ? FaceNeighbourhood::Edges : FaceNeighbourhood::Vertices;
}

ParameterSpec vertex_steps_parameter(std::uint32_t standard) {
  return count_parameter("vertex_steps", standard, 1, 100, "How often the vertices move per iteration.");
}

ParameterSpec centroid_distance_parameter(std::string name, double standard) {
  return number_parameter(std::move(name), standard, 0.1, 100, "mean distances of adjacent centroids",
                          "Standard deviation of the distance between centroids.");
}

}  // namespace burnish
