#include "core/measure/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/simd_vec3.h"
#include "core/run/buffer.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

/// Steps of smoothing that make the copy whose normals and edges stand for the true ones.
constexpr int kSteps = 2;
/// Variance that (I - P)^2 gives independent noise of variance 1 on a regular mesh, P the mean of the six
/// neighbours: 1 + 6/6 - 4/18 + 90/1296, from the closed walks of two, three and four steps.
constexpr double kVariance = 1.8472;
/// What is left of noise of strength 1 by measuring it on meshes whose edges the copy has shortened.
constexpr double kBias = 1.05;
/// Below this the differences are the surface's own.
constexpr double kLeast = 0.03;
/// An impulse stands out so much from the rest and from its own neighbours, at so many vertices.
constexpr float kAboveRest = 4, kAboveNeighbours = 1.8F;
constexpr double kManyPeaks = 0.01;
/// Where all the rest is smoother than the first of these, in edge lengths, corners stand out like impulses:
/// twice as many are needed; fewer and fewer up to the second.
constexpr double kSmoothRest = 0.007, kRoughRest = 0.012;
/// Impulses that have others beside them are no peaks, and widen the rest instead: what the peaks' own
/// strength is times, before that of the rest is added.
constexpr double kHiddenPeaks = 1.25;

class Estimator {
 public:
  Estimator(const Surface& surface, std::span<const Vec3f> positions, const RunControl& run)
      : triangles_(surface.mesh.triangles),
        topology_(surface.topology),
        positions_(positions),
        run_(run),
        size_(positions.size()),
        smooth_(size_),
        heights_(size_),
        residuals_(size_) {}

  NoiseEstimate estimate() {
    if (!smooth() || !measure_residuals() || samples_.size() < kFewest) return {};
    const double h = smooth_edge();
    if (!(h > 0)) return {};
    const double usual = core(), all = root_mean_square();
    // Noise without tails has a narrower spread than its middle suggests.
    NoiseEstimate estimate{std::min(usual, all) / (h * kBias), NoiseEstimate::Kind::Gaussian};
    const double smoothness = (kRoughRest - usual / h) / (kRoughRest - kSmoothRest);
    const Peaks peaks = find_peaks(static_cast<float>(usual * std::sqrt(kVariance)));
    if (all > kLeast * h * kBias && peaks.share > kManyPeaks * (1 + std::clamp(smoothness, 0.0, 1.0))) {
      // The whole holds the edges, too, which on machined parts are more than the impulses.
      const double above = kHiddenPeaks * peaks.sigma + usual;
      return {std::min(all / kBias, above) / h, NoiseEstimate::Kind::Impulsive};
    }
    if (estimate.sigma_over_edge < kLeast) estimate.kind = NoiseEstimate::Kind::None;
    return estimate;
  }

 private:
  static constexpr std::size_t kFewest = 16;

  bool inner(std::size_t v) const { return topology_.vertex_flags[v] == 0; }

  bool smooth() {
    Buffer<SimdVec3> next(size_);
    if (!for_each(size_, run_, [&](std::size_t v) { smooth_[v] = SimdVec3(positions_[v]); })) {
      return false;
    }
    for (int step = 0; step < kSteps; ++step) {
      const bool done = for_each(size_, run_, [&](std::size_t v) {
        SimdVec3 sum = smooth_[v];
        const auto row = topology_.vertex_neighbours[v];
        for (const Index w : row) sum += smooth_[w];
        next[v] = inner(v) ? sum * (1 / static_cast<float>(row.size() + 1)) : smooth_[v];
      });
      if (!done) return false;
      smooth_.swap(next);
    }
    return true;
  }

  /// (I - P)^2 of the heights over the smooth copy: how far each vertex is from where its neighbours would
  /// have it, less the same of these. The first difference still holds the surface's curvature.
  bool measure_residuals() {
    const auto& positions = positions_;
    const bool first = for_each(size_, run_, [&](std::size_t v) {
      SimdVec3 sum, normal;
      const auto row = topology_.vertex_neighbours[v];
      for (const Index w : row) sum += SimdVec3(positions[w]);
      for (const Index f : topology_.vertex_faces[v]) {
        const auto& [a, b, c] = triangles_[f];
        normal += cross(smooth_[b] - smooth_[a], smooth_[c] - smooth_[a]);
      }
      const float size = length(normal);
      const SimdVec3 way =
          SimdVec3(positions[v]) - sum * (1 / static_cast<float>(std::max<std::size_t>(row.size(), 1)));
      heights_[v] = size > 0 ? dot(way, normal) / size : 0;
    });
    const bool second =
        first && for_each(size_, run_, [&](std::size_t v) {
          const auto row = topology_.vertex_neighbours[v];
          const bool usable = inner(v) && std::ranges::all_of(row, [&](Index w) { return inner(w); });
          float sum = 0;
          for (const Index w : row) sum += heights_[w];
          // Fewer neighbours average less away: the factor is 1 where there are six.
          const float n = static_cast<float>(row.size()), irregular = (1 + 1 / n) * (6.0F / 7);
          residuals_[v] = usable ? std::abs(heights_[v] - sum / n) / irregular : -1;
        });
    if (!second) return false;
    for (const float r : residuals_) {
      if (r >= 0) samples_.push_back(r);
    }
    return true;
  }

  /// Standard deviation of the noise, from those vertices that look like nothing else: the median of what is
  /// within 1.5 standard deviations, until it agrees with itself. Edges and folds fall out.
  double core() {
    constexpr double kMedian = 0.67449, kMedianWithin = 0.5722, kWithin = 1.5;
    double sigma = quantile(samples_.end(), 0.5) / kMedian;
    for (int round = 0; round < 8; ++round) {
      const auto end = std::partition(samples_.begin(), samples_.end(),
                                      [&](float r) { return static_cast<double>(r) <= kWithin * sigma; });
      if (end - samples_.begin() < static_cast<std::ptrdiff_t>(kFewest)) break;
      sigma = quantile(end, 0.5) / kMedianWithin;
    }
    return sigma / std::sqrt(kVariance);
  }

  double quantile(std::vector<float>::iterator end, double share) {
    const auto at = samples_.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(end - samples_.begin() - 1));
    std::nth_element(samples_.begin(), at, end);
    return static_cast<double>(*at);
  }

  /// Vertices that stand out alone: which share of all they are, and what all would vary by if the others did
  /// not. Edges stand out too, but in rows.
  struct Peaks {
    double share, sigma;
  };
  Peaks find_peaks(float rest) const {
    const auto is_peak = [&](std::size_t v) {
      return residuals_[v] > kAboveRest * rest &&
             std::ranges::all_of(topology_.vertex_neighbours[v], [&](Index w) {
               return std::abs(heights_[v]) > kAboveNeighbours * std::abs(heights_[w]);
             });
    };
    const auto mean = [&](auto&& value) {
      return parallel_sum(size_, run_,
                          [&](std::size_t begin, std::size_t end) {
                            double sum = 0;
                            for (std::size_t v = begin; v < end; ++v) sum += is_peak(v) ? value(v) : 0;
                            return sum;
                          }) /
             static_cast<double>(size_);
    };
    const auto square = [&](std::size_t v) {
      const double r = static_cast<double>(residuals_[v]);
      return r * r;
    };
    return {mean([](std::size_t) { return 1.0; }), std::sqrt(mean(square) / kVariance)};
  }

  double root_mean_square() const {
    double sum = 0;
    for (const float r : samples_) sum += static_cast<double>(r) * static_cast<double>(r);
    return std::sqrt(sum / (kVariance * static_cast<double>(samples_.size())));
  }

  double smooth_edge() const {
    const double sum = parallel_sum(size_, run_, [&](std::size_t begin, std::size_t end) {
      double lengths = 0;
      for (std::size_t v = begin; v < end; ++v) {
        for (const Index w : topology_.vertex_neighbours[v]) {
          lengths += static_cast<double>(length(smooth_[w] - smooth_[v]));
        }
      }
      return lengths;
    });
    return topology_.edges > 0 ? sum / (2.0 * topology_.edges) : 0;
  }

  const std::span<const Triangle> triangles_;
  const Topology& topology_;
  const std::span<const Vec3f> positions_;
  const RunControl& run_;
  const std::size_t size_;
  Buffer<SimdVec3> smooth_;
  Buffer<float> heights_;       // over the mean of the neighbours
  Buffer<float> residuals_;     // absolute; -1 where a boundary is near
  std::vector<float> samples_;  // the others
};

}  // namespace

std::string_view name_of(NoiseEstimate::Kind kind) {
  switch (kind) {
    case NoiseEstimate::Kind::None:
      return "none";
    case NoiseEstimate::Kind::Gaussian:
      return "gaussian";
    case NoiseEstimate::Kind::Impulsive:
      return "impulsive";
  }
  return "";
}

NoiseEstimate estimate_noise(const Surface& surface, std::span<const Vec3f> positions,
                             const RunControl& run) {
  return Estimator(surface, positions, run).estimate();
}

}  // namespace burnish
