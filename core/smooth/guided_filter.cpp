#include "core/smooth/guided_filter.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/run/math.h"

namespace burnish {
namespace {

using Row = SimdVec3::Lanes;

/// A few indices, forgotten at once.
class FewIndices {
 public:
  void clear() { ++now_; }
  /// True when it was not there.
  bool insert(Index index) {
    std::size_t at = index % kPlaces;
    for (; places_[at].since == now_; at = (at + 1) % kPlaces) {
      if (places_[at].index == index) return false;
    }
    places_[at] = {index, now_};
    return true;
  }

 private:
  static constexpr std::size_t kPlaces = 1024;  // more than twice as many as ever are in it
  struct Place {
    Index index, since;
  };
  std::vector<Place> places_ = std::vector<Place>(kPlaces);
  Index now_ = 0;
};

/// Finds the neighbours of one face after the other; keeps its memory.
class Walk {
 public:
  Walk(const Faces& faces, float radius) : faces_(faces), squared_radius_(radius * radius) {}

  /// Those of f, f and its patch first.
  std::span<const Index> around(Index f) {
    const auto& triangles = faces_.surface().mesh.triangles;
    centre_ = faces_.centroid(f);
    found_.assign(1, f);
    faces_seen_.clear();
    faces_seen_.insert(f);
    vertices_seen_.clear();
    for (const Index v : triangles[f]) {
      vertices_seen_.insert(v);
      visit(v, [](Index) { return true; });
    }
    patch_size_ = found_.size();
    for (std::size_t i = 1; i < found_.size(); ++i) {
      if (i < patch_size_ && !is_near(found_[i])) continue;
      for (const Index v : triangles[found_[i]]) {
        if (vertices_seen_.insert(v)) visit(v, [&](Index n) { return is_near(n); });
      }
    }
    return found_;
  }
  std::size_t patch_size() const { return patch_size_; }

 private:
  bool is_near(Index f) const {
    const SimdVec3 way = faces_.centroid(f) - centre_;
    return dot(way, way) <= squared_radius_;
  }
  template <class Wanted>
  void visit(Index v, Wanted&& wanted) {
    const auto faces = faces_.surface().topology.vertex_faces[v];
    for (const Index n : faces.first(std::min(faces.size(), GuidedFilter::kMostNear))) {
      if (found_.size() == GuidedFilter::kMostNear) return;
      if (wanted(n) && faces_seen_.insert(n)) found_.push_back(n);
    }
  }

  const Faces& faces_;
  const float squared_radius_;
  SimdVec3 centre_;
  std::vector<Index> found_;
  FewIndices faces_seen_, vertices_seen_;
  std::size_t patch_size_ = 0;
};

/// Sums of the lanes of four rows.
FourFloats add_across(Row a, Row b, Row c, Row d) {
  const Row ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Row cd = __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

/// 1 / (sqrt(2) sigma), with a square that is finite for any sigma: meshes may have shrunk to a point.
float scale_of(double sigma) {
  constexpr double kMost = 1e15, kRootHalf = 0.70710678118654752;
  return static_cast<float>(std::min(kMost, kRootHalf / sigma));
}

}  // namespace

GuidedFilter::GuidedFilter(const Faces& faces, double radius)
    : topology_(faces.surface().topology),
      triangles_(faces.surface().mesh.triangles),
      run_(faces.run()),
      offsets_(faces.size() + 1),
      patch_sizes_(faces.size()),
      given_(faces.size() + 1),
      turns_(faces.size()),
      rings_(faces.surface().mesh.positions.size()),
      means_(faces.size()),
      consistency_(faces.size()) {
  const Index nothing = static_cast<Index>(faces.size());
  given_[nothing] = Given{};
  const float within = static_cast<float>(radius * faces.mean_centroid_distance());
  std::vector<std::vector<Index>> blocks(block_count(faces.size()));
  const bool found = parallel_for(faces.size(), run_, [&](std::size_t begin, std::size_t end) {
    std::vector<Index>& block = blocks[begin / block_size(faces.size())];
    Walk walk(faces, within);
    for (std::size_t f = begin; f < end; ++f) {
      const auto near = walk.around(static_cast<Index>(f));
      block.insert(block.end(), near.begin(), near.end());
      block.resize((block.size() + 3) / 4 * 4, nothing);
      offsets_[f + 1] = block.size();  // from the block's beginning
      patch_sizes_[f] = static_cast<std::uint8_t>(walk.patch_size());
    }
  });
  if (!found) return;
  std::vector<std::size_t> starts(blocks.size() + 1);
  for (std::size_t b = 0; b < blocks.size(); ++b) starts[b + 1] = starts[b] + blocks[b].size();
  near_.resize(starts.back());
  parallel_for(faces.size(), run_, [&](std::size_t begin, std::size_t end) {
    const std::size_t b = begin / block_size(faces.size());
    std::ranges::copy(blocks[b], near_.begin() + static_cast<std::ptrdiff_t>(starts[b]));
    std::vector<Index>().swap(blocks[b]);  // at once: together they take as much again
    for (std::size_t f = begin; f < end; ++f) offsets_[f + 1] += starts[b];
  });
}

bool GuidedFilter::filter(Faces& faces, const GuidedWidths& widths) {
  return !run_.stopped() &&  // also during the constructor
         give(faces, scale_of(widths.sigma_s * faces.mean_centroid_distance())) && gather_rings() &&
         rate_patches(faces) && guide(scale_of(widths.sigma_r)) &&
         faces.filter([&](std::size_t f) { return filtered(f, faces.normal(f)); });
}

/// What the faces give apart from the guide, and phi.
bool GuidedFilter::give(const Faces& faces, float per_sigma_s) {
  return for_each(faces.size(), run_, [&](std::size_t f) {
    const SimdVec3 normal = faces.normal(f);
    Row pull = (normal * faces.twice_area(f)).lanes();
    std::array<float, 3> turn = {};
    pull[3] = faces.twice_area(f);
    given_[f].pull = pull;
    given_[f].place = (faces.centroid(f) * per_sigma_s).lanes();
    for (std::size_t side = 0; side < 3; ++side) {
      const Index across = topology_.face_neighbours[f][side];
      if (across != kNone) turn[side] = length(normal - faces.normal(across));
    }
    turns_[f] = turn;
  });
}

bool GuidedFilter::gather_rings() {
  return for_each(rings_.size(), run_, [&](std::size_t v) {
    Ring ring;
    for (const Index f : topology_.vertex_faces[v]) {
      const Triangle& t = triangles_[f];
      const std::size_t corner = (t[1] == v ? 1U : 0U) + (t[2] == v ? 2U : 0U);
      const float one = turns_[f][corner], other = turns_[f][(corner + 2) % 3];
      ring.pull += given_[f].pull;
      ring.sum += one + other;
      ring.most = std::max({ring.most, one, other});
    }
    ring.sum *= 0.5F;  // every edge came from both sides
    rings_[v] = ring;
  });
}

/// H and the mean normals of the patches, from the rings of their three corners.
bool GuidedFilter::rate_patches(const Faces& faces) {
  return for_each(faces.size(), run_, [&](std::size_t f) {
    const auto& [a, b, c] = triangles_[f];
    const auto& turn = turns_[f];
    const float sum = rings_[a].sum + rings_[b].sum + rings_[c].sum - (turn[0] + turn[1] + turn[2]);
    const float most = std::max({rings_[a].most, rings_[b].most, rings_[c].most});
    Row pull = rings_[a].pull + rings_[b].pull + rings_[c].pull - 2 * given_[f].pull;
    for (const Index across : topology_.face_neighbours[f]) {
      if (across != kNone) pull -= given_[across].pull;
    }
    const float areas = pull[3];
    pull[3] = 0;
    means_[f] = unit_or(SimdVec3(pull), areas, {});
    constexpr float kEpsilon = 1e-9F;
    consistency_[f] = dot(means_[f], means_[f]) > 0
                          ? largest_difference(faces.normals(), f) * most / (kEpsilon + sum)
                          : std::numeric_limits<float>::max();
  });
}

/// Phi.
float GuidedFilter::largest_difference(std::span<const SimdVec3> normals, std::size_t f) const {
  const auto faces = patch(f);
  const std::size_t fours = (faces.size() + 3) / 4;
  std::array<FourFloats, kMostNear / 4> x, y, z;
  for (std::size_t i = 0; i < fours; ++i) {  // the last one may come several times
    const auto normal = [&](std::size_t k) {
      return normals[faces[std::min(4 * i + k, faces.size() - 1)]].lanes();
    };
    const Row a = normal(0), b = normal(1), c = normal(2), d = normal(3);
    const Row ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    x[i] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    y[i] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    z[i] = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 3, 7),
                                   __builtin_shufflevector(c, d, 2, 6, 3, 7), 0, 1, 4, 5);
  }
  FourFloats most = {};
  for (std::size_t i = 0; i < fours; ++i) {
    for (std::size_t k = i; k < fours; ++k) {
      for (std::size_t one = 0; one < 4; ++one) {
        const FourFloats dx = x[k] - x[i][one], dy = y[k] - y[i][one], dz = z[k] - z[i][one];
        const FourFloats squared = dx * dx + dy * dy + dz * dz;
        most = squared > most ? squared : most;
      }
    }
  }
  return std::sqrt(std::max({most[0], most[1], most[2], most[3]}));
}

bool GuidedFilter::guide(float per_sigma_r) {
  return for_each(means_.size(), run_, [&](std::size_t f) {
    Index best = static_cast<Index>(f);
    float least = consistency_[f];
    for (const Index j : patch(f)) {  // selects instead of branches: nobody can guess them
      const float rated = consistency_[j];
      best = rated < least ? j : best;
      least = rated < least ? rated : least;
    }
    given_[f].guide = (means_[best] * per_sigma_r).lanes();
  });
}

SimdVec3 GuidedFilter::filtered(std::size_t f, SimdVec3 own) const {
  const Given& centre = given_[f];
  const auto squared_distance = [&](const Given& other) {
    const Row way = other.place - centre.place, turn = other.guide - centre.guide;
    return way * way + turn * turn;
  };
  Row sum = {};
  const auto faces = near(f);
  for (std::size_t i = 0; i < faces.size(); i += 4) {
    const Given *a = &given_[faces[i]], *b = &given_[faces[i + 1]], *c = &given_[faces[i + 2]],
                *d = &given_[faces[i + 3]];
    const FourFloats weights = portable_exp(
        -add_across(squared_distance(*a), squared_distance(*b), squared_distance(*c), squared_distance(*d)));
    sum += a->pull * weights[0] + b->pull * weights[1] + c->pull * weights[2] + d->pull * weights[3];
  }
  const float weights = sum[3];
  sum[3] = 0;
  return unit_or(SimdVec3(sum), weights, own);
}

}  // namespace burnish
