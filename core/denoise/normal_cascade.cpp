#include "core/denoise/normal_cascade.h"

#include <algorithm>

#include "core/denoise/facets.h"
#include "core/denoise/outliers.h"
#include "core/denoise/planes.h"
#include "core/denoise/surface_class.h"
#include "core/denoise/turned.h"

namespace burnish {
namespace {

/// Steps that smooth what was given back.
constexpr std::uint32_t kStepsAfterwards = 4;
/// The widest filter of NormalFields.
constexpr std::size_t kWidest = 3;
/// Cosine below which a triangle is folded over, and steps that unfold it.
constexpr float kFolded = 0.4F;
constexpr int kUnfoldSteps = 3;

}  // namespace

NormalCascade::NormalCascade(const Surface& surface, std::span<const std::uint8_t> movable,
                             const CascadeOptions& options, std::span<const NormalNetwork> networks,
                             const RunControl& run)
    : surface_(surface),
      movable_(movable),
      options_(options),
      networks_(networks),
      run_(run),
      faces_(surface, FaceNeighbourhood::Vertices, run),
      patches_(std::in_place, surface, faces_, run),
      predicted_(faces_.size()),
      now_(movable_.size()),
      next_(movable_.size()) {}

bool NormalCascade::advance(std::span<const SimdVec3> from) {
  const NormalNetwork& network = networks_[std::min(stage_++, networks_.size() - 1)];
  const auto predict = [&](const NormalFields& fields) {
    return network.predict(fields, patches_->whole(), run_, predicted_);
  };
  return patches_->measure(from, predict) &&
         for_each(now_.size(), run_, [&](std::size_t v) { now_[v] = next_[v] = from[v]; }) && unfold() &&
         fit(predicted_, options_.vertex_steps) &&
         (std::max(options_.give_back, options_.give_back_flat) == 0 ||
          (give_back() && fit(predicted_, kStepsAfterwards)));
}

/// Noise along the surface folds triangles over. Where one turns away from its prediction, its corners go
/// half the way to the middle of their neighbours, within the surface.
bool NormalCascade::unfold() {
  Buffer<std::uint8_t> folded(faces_.size());
  const auto is_folded = [&](Index f) { return folded[f] != 0; };
  bool going = true;
  for (int step = 0; going && step < kUnfoldSteps; ++step) {
    going = for_each(faces_.size(), run_,
                     [&](std::size_t f) {
                       folded[f] = dot(faces_.measured(now_, f).normal, predicted_[f]) < kFolded;
                     }) &&
            for_each(now_.size(), run_, [&](std::size_t v) {
              next_[v] = now_[v];
              if (!movable(v) || std::ranges::none_of(surface_.topology.vertex_faces[v], is_folded)) return;
              const SimdVec3 normal = normal_at(v), way = umbrella(now_, surface_.topology, v);
              next_[v] = now_[v] + (way - normal * dot(way, normal)) * 0.5F;
            });
    now_.swap(next_);
  }
  return going && for_each(now_.size(), run_, [&](std::size_t v) { next_[v] = now_[v]; });
}

/// v' = v + mean over triangles f at v of [(c(f) - v) . n(f)] n(f).
bool NormalCascade::fit(Buffer<SimdVec3>& normals, std::uint32_t steps) {
  faces_.swap_normals(normals);
  bool going = true;
  for (std::uint32_t step = 0; going && step < steps; ++step) {
    going = faces_.measure_centroids(now_) && for_each(now_.size(), run_, [&](std::size_t v) {
              if (movable(v)) next_[v] = now_[v] + faces_.offset_by_count(now_[v], v);
            });
    now_.swap(next_);
  }
  faces_.swap_normals(normals);
  faces_.release_centroids();
  return going;
}

SimdVec3 NormalCascade::normal_at(std::size_t v) const {
  SimdVec3 sum;
  for (const Index f : surface_.topology.vertex_faces[v]) sum += predicted_[f];
  return unit_or(sum, 1, {});
}

bool NormalCascade::average_over_rings(std::uint32_t rings, Buffer<float>& heights,
                                       Buffer<float>& next) const {
  bool going = true;
  for (std::uint32_t ring = 0; going && ring < rings; ++ring) {
    going = for_each(now_.size(), run_, [&](std::size_t v) {
      const auto row = surface_.topology.vertex_neighbours[v];
      float sum = heights[v];
      for (const Index w : row) sum += heights[w];
      next[v] = sum / (1 + static_cast<float>(row.size()));
    });
    heights.swap(next);
  }
  return going;
}

/// What the vertices lost in height, without its fast changes, which are the noise.
bool NormalCascade::give_back() {
  const double share = share_of_flat_edges(surface_.topology, predicted_, run_);
  const auto flat =
      static_cast<float>(std::clamp((share - kCurvedSurface) / (kFlatSurface - kCurvedSurface), 0.0, 1.0));
  // By rings: heights after the fewer, then after the more.
  const auto [fewer, more] = std::minmax(options_.give_back, options_.give_back_flat);
  const float by_more = options_.give_back <= options_.give_back_flat ? flat : 1 - flat;
  Buffer<float> heights(now_.size()), next(now_.size()), near(now_.size());
  return for_each(
             now_.size(), run_,
             [&](std::size_t v) { heights[v] = movable(v) ? dot(home(v) - now_[v], normal_at(v)) : 0; }) &&
         average_over_rings(fewer, heights, next) &&
         for_each(now_.size(), run_, [&](std::size_t v) { near[v] = heights[v]; }) &&
         average_over_rings(by_more > 0 ? more - fewer : 0, heights, next) &&
         for_each(now_.size(), run_, [&](std::size_t v) {
           const float height = near[v] + (heights[v] - near[v]) * by_more;
           if (movable(v)) now_[v] = next_[v] = now_[v] + normal_at(v) * height;
         });
}

bool NormalCascade::finish() {
  patches_.reset();
  if (options_.only_outliers) {
    Buffer<float> moves(now_.size());
    Buffer<std::uint8_t> outlier(now_.size());
    const auto measure = [&](std::size_t v) { moves[v] = length(now_[v] - home(v)); };
    if (!for_each(now_.size(), run_, measure)) return false;
    if (find_outliers(surface_.topology, movable_, moves, outlier, run_)) return keep_exact(outlier);
  }
  return options_.facet_steps + options_.plane_steps == 0 || sharpen();
}

bool NormalCascade::sharpen() {
  Buffer<SimdVec3> learned(now_.size());
  bool going = for_each(now_.size(), run_, [&](std::size_t v) { learned[v] = now_[v]; });
  if (going && options_.facet_steps > 0) {
    going = smooth_facets(faces_, movable_, options_.facet_steps, now_, next_);
  }
  faces_.release_centroids();
  if (going && options_.plane_steps > 0) {
    Buffer<SimdVec3> normals(faces_.size());
    if (options_.facet_steps > 0) {
      faces_.swap_normals(normals);
    } else {
      going = for_each(normals.size(), run_, [&](std::size_t f) { normals[f] = predicted_[f]; });
    }
    going = going && settle_on_planes(faces_, movable_, options_.plane_steps, normals, now_, next_);
  }
  return going && take_back_turned(faces_, predicted_, learned, now_);
}

/// Where no corner is off, the scan's own normals are the best; outliers move to fit those and the predicted
/// ones of their own triangles.
bool NormalCascade::keep_exact(std::span<const std::uint8_t> outlier) {
  const auto is_outlier = [&](Index v) { return outlier[v] != 0; };
  bool going = for_each(now_.size(), run_, [&](std::size_t v) {
    if (outlier[v] == 0) now_[v] = home(v);
    next_[v] = now_[v];
  });
  going = going && for_each(faces_.size(), run_, [&](std::size_t f) {
            if (std::ranges::none_of(surface_.mesh.triangles[f], is_outlier)) {
              predicted_[f] = faces_.measured(now_, f).normal;
            }
          });
  faces_.swap_normals(predicted_);
  for (std::uint32_t step = 0; going && step < options_.vertex_steps; ++step) {
    going = faces_.measure_centroids(now_) && for_each(now_.size(), run_, [&](std::size_t v) {
              if (outlier[v] != 0) next_[v] = now_[v] + faces_.offset_by_count(now_[v], v);
            });
    now_.swap(next_);
  }
  faces_.swap_normals(predicted_);
  return going;
}

bool NormalCascade::stay_behind(float share) {
  return for_each(now_.size(), run_, [&](std::size_t v) { now_[v] = home(v) + (now_[v] - home(v)) * share; });
}

bool NormalCascade::go_beyond(float share) {
  Buffer<SimdVec3> learned(now_.size()), wide(faces_.size());
  const auto take_widest = [&](const NormalFields& fields) {
    return for_each(fields.size(), run_,
                    [&](std::size_t f) { wide[fields.number(f)] = fields.field(kWidest, f); });
  };
  return for_each(now_.size(), run_, [&](std::size_t v) { learned[v] = now_[v]; }) &&
         patches_.emplace(surface_, faces_, run_).measure(now_, take_widest) &&
         fit(wide, options_.vertex_steps) && for_each(now_.size(), run_, [&](std::size_t v) {
           now_[v] = learned[v] + (now_[v] - learned[v]) * share;
         });
}

bool NormalCascade::unflip(std::span<SimdVec3> positions) const {
  return take_back_flipped(faces_, predicted_, positions);
}

}  // namespace burnish
