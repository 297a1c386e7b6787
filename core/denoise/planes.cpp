#include "core/denoise/planes.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

namespace burnish {
namespace {

/// Lengths of differences of unit normals: of triangles that are of one plane as far as their edge tells, and
/// of one that turns away from the plane of the others once its neighbours have evened it out.
constexpr float kBend = 0.08F, kTurn = 0.1F;
/// Rounds over neighbours that even normals out.
constexpr int kEvening = 3;
/// Triangles of a plane, at least, and the share of what is connected that does not turn away.
constexpr std::size_t kFewest = 64;
constexpr double kShare = 0.85;
/// Root mean squares of a quadric through what should be a plane: its height over how far the scan is off,
/// and its slope.
constexpr double kCurved = 0.2, kSlope = 0.03;
/// What turns away but is no higher over the plane, in mean edge lengths, is of it after all.
constexpr float kLow = 0.1F;
/// Triangles at creases find their plane once it is there.
constexpr int kRounds = 2;

struct Plane {
  SimdVec3 normal, point;
  SimdVec3 way_from(SimdVec3 p) const { return normal * dot(point - p, normal); }
};

Eigen::Vector3d to_eigen(SimdVec3 v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}
SimdVec3 from_eigen(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

class Planes {
 public:
  Planes(const Faces& faces, std::span<const SimdVec3> normals, std::span<const SimdVec3> positions)
      : faces_(faces),
        across_(faces.surface().topology.face_neighbours),
        normals_(normals),
        positions_(positions),
        plane_at_(faces.size(), kUnseen) {}

  /// False when stopped.
  bool find() {
    std::vector<Index> candidates;  // one part after the other
    std::vector<std::size_t> ends;
    for (std::size_t seed = 0; seed < faces_.size(); ++seed) {
      if (seed % kBlockSize == 0 && faces_.run().stopped()) return false;
      if (plane_at_[seed] != kUnseen) continue;
      if (!connect(static_cast<Index>(seed))) return false;
      if (!is_nearly_flat()) continue;
      candidates.insert(candidates.end(), part_.begin(), part_.end());
      ends.push_back(candidates.size());
    }
    if (ends.empty()) return true;
    if (!even_normals()) return false;
    std::size_t begin = 0;
    for (const std::size_t end : ends) {
      if (faces_.run().stopped()) return false;
      part_.assign(candidates.begin() + static_cast<std::ptrdiff_t>(begin),
                   candidates.begin() + static_cast<std::ptrdiff_t>(end));
      begin = end;
      const auto plane = plane_of_part();
      if (!plane) continue;
      for (const Index f : part_) plane_at_[f] = static_cast<Index>(planes_.size());
      planes_.push_back(*plane);
    }
    return !faces_.run().stopped();
  }

  bool empty() const { return planes_.empty(); }
  /// Of the triangle; null when it is on none.
  const Plane* operator[](Index f) const { return plane_at_[f] == kNone ? nullptr : &planes_[plane_at_[f]]; }

 private:
  static constexpr Index kUnseen = kNone - 1;

  bool connected(Index f, Index g) const { return g != kNone && length(normals_[f] - normals_[g]) <= kBend; }

  bool even_normals() {
    evened_.assign(normals_.begin(), normals_.end());
    Buffer<SimdVec3> next(evened_.size());
    bool going = true;
    for (int round = 0; going && round < kEvening; ++round) {
      going = for_each(evened_.size(), faces_.run(), [&](std::size_t f) {
        SimdVec3 sum = evened_[f];
        for (const Index g : across_[f]) {
          if (connected(static_cast<Index>(f), g)) sum += evened_[g];
        }
        next[f] = unit_or(sum, 1, evened_[f]);
      });
      evened_.swap(next);
    }
    return going;
  }

  /// What is connected to the seed becomes the part, and is seen. False when stopped.
  bool connect(Index seed) {
    part_.assign(1, seed);
    plane_at_[seed] = kNone;
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (i % kBlockSize == kBlockSize - 1 && faces_.run().stopped()) return false;
      for (const Index g : across_[part_[i]]) {
        if (!connected(part_[i], g) || plane_at_[g] != kUnseen) continue;
        plane_at_[g] = kNone;
        part_.push_back(g);
      }
    }
    return true;
  }

  /// What was computed when it stopped means nothing.
  template <class Visit>
  void for_each_until_stopped(std::span<const Index> part, Visit&& visit) const {
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (i % kBlockSize == kBlockSize - 1 && faces_.run().stopped()) return;
      visit(part[i]);
    }
  }

  struct Mean {
    SimdVec3 area_normal;
    double twice_area = 0;
  };
  Mean mean_of(std::span<const Index> part) const {
    Mean mean;
    for_each_until_stopped(part, [&](Index f) {
      const auto face = faces_.measured(positions_, f);
      mean.area_normal += face.normal * face.twice_area;
      mean.twice_area += static_cast<double>(face.twice_area);
    });
    return mean;
  }

  bool is_nearly_flat() const {
    if (part_.size() < kFewest) return false;
    const Mean mean = mean_of(part_);
    return static_cast<double>(length(mean.area_normal)) > kShare * kShare * mean.twice_area;
  }

  /// The part's plane, if it has one; what is not of it leaves the part.
  std::optional<Plane> plane_of_part() {
    Mean mean = mean_of(part_);
    const double whole = mean.twice_area;
    SimdVec3 normal;
    for (int round = 0; round < 3; ++round) {
      normal = unit_or(mean.area_normal, 0, normal);
      kept_.clear();
      std::ranges::copy_if(part_, std::back_inserter(kept_), [&](Index f) { return !turns(f, normal); });
      mean = mean_of(kept_);
    }
    if (kept_.size() < kFewest || mean.twice_area < kShare * whole) return {};
    const auto plane = fit(kept_, to_eigen(unit_or(mean.area_normal, 0, normal)), mean.twice_area);
    if (!plane) return {};
    const float low = kLow * static_cast<float>(faces_.surface().mean_edge);
    std::erase_if(part_, [&](Index f) {
      return turns(f, normal) && length(plane->way_from(faces_.measured(positions_, f).centroid)) > low;
    });
    return plane;
  }

  bool turns(Index f, SimdVec3 normal) const { return length(evened_[f] - normal) > kTurn; }

  /// Through centroids, by least squares, weighted by area; in a frame along `normal` whose unit is the root
  /// of the area.
  std::optional<Plane> fit(std::span<const Index> part, const Eigen::Vector3d& normal,
                           double twice_area) const {
    using Terms = Eigen::Matrix<double, 6, 1>;  // of a quadric: 1, x, y, x^2, xy, y^2
    const Mesh& scan = faces_.surface().mesh;
    const Eigen::Vector3d along_x = normal.unitOrthogonal(), along_y = normal.cross(along_x);
    const double scale = 1 / std::sqrt(twice_area);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for_each_until_stopped(part, [&](Index f) {
      const auto face = faces_.measured(positions_, f);
      centre += to_eigen(face.centroid) * (static_cast<double>(face.twice_area) / twice_area);
    });
    Eigen::Matrix<double, 6, 6> products = Eigen::Matrix<double, 6, 6>::Zero();
    Terms with_height = Terms::Zero();
    double scan_heights = 0;  // mean of squares
    for_each_until_stopped(part, [&](Index f) {
      const auto face = faces_.measured(positions_, f);
      const Eigen::Vector3d way = (to_eigen(face.centroid) - centre) * scale;
      const double x = way.dot(along_x), y = way.dot(along_y), z = way.dot(normal);
      const Terms terms{1, x, y, x * x, x * y, y * y};
      const double weight = static_cast<double>(face.twice_area) / twice_area;
      products += weight * terms * terms.transpose();
      with_height += weight * z * terms;
      for (const Index corner : scan.triangles[f]) {
        const double off = (to_eigen(SimdVec3(scan.positions[corner])) - centre).dot(normal) * scale;
        scan_heights += weight / 3 * off * off;
      }
    });
    const Eigen::Vector3d plane = products.topLeftCorner<3, 3>().ldlt().solve(with_height.head<3>());
    const double tilted = plane.dot(with_height.head<3>());
    products.diagonal().tail<3>().array() += 1e-9;  // a strip has no second curvature
    const Terms quadric = products.ldlt().solve(with_height);
    const double a = 2 * quadric[3], b = quadric[4], c = 2 * quadric[5];  // slopes: a x + b y, b x + c y
    const double slopes = (a * a + b * b) * products(1, 1) + 2 * (a + c) * b * products(1, 2) +
                          (b * b + c * c) * products(2, 2);
    const bool flat = quadric.dot(with_height) - tilted < kCurved * kCurved * (scan_heights - tilted);
    if (!flat || !(slopes < kSlope * kSlope)) return {};
    return Plane{from_eigen((normal - plane[1] * along_x - plane[2] * along_y).normalized()),
                 from_eigen(centre + normal * (plane[0] / scale))};
  }

  const Faces& faces_;
  const std::span<const Triangle> across_;
  const std::span<const SimdVec3> normals_, positions_;
  Buffer<SimdVec3> evened_;
  std::vector<Index> plane_at_;  // by triangle; kNone: on none
  std::vector<Plane> planes_;
  std::vector<Index> part_, kept_;
};

}  // namespace

bool settle_on_planes(Faces& faces, std::span<const std::uint8_t> movable, std::uint32_t steps,
                      Buffer<SimdVec3>& normals, Buffer<SimdVec3>& now, Buffer<SimdVec3>& next) {
  const RunControl& run = faces.run();
  const auto& vertex_faces = faces.surface().topology.vertex_faces;
  bool going = true;
  for (int round = 0; going && round < kRounds; ++round) {
    Planes planes(faces, normals, now);
    if (!planes.find()) return false;
    if (planes.empty()) break;
    const auto on_plane = [&](Index f) { return planes[f] != nullptr; };
    going = for_each(faces.size(), run, [&](std::size_t f) {
      if (const Plane* plane = planes[static_cast<Index>(f)]) normals[f] = plane->normal;
    });
    std::vector<Index> settling;
    for (std::size_t v = 0; v < movable.size(); ++v) {
      if (movable[v] != 0 && std::ranges::any_of(vertex_faces[v], on_plane))
        settling.push_back(static_cast<Index>(v));
    }
    for (std::uint32_t step = 0; going && step < steps; ++step) {
      going = for_each(settling.size(), run, [&](std::size_t i) {
        const Index v = settling[i];
        const auto around = vertex_faces[v];
        SimdVec3 sum;
        for (const Index f : around) {
          const Plane* plane = planes[f];
          sum += plane != nullptr ? plane->way_from(now[v])
                                  : normals[f] * dot(faces.measured(now, f).centroid - now[v], normals[f]);
        }
        next[v] = now[v] + sum * (1 / static_cast<float>(around.size()));
      });
      now.swap(next);
    }
    going =
        going && for_each(settling.size(), run, [&](std::size_t i) { next[settling[i]] = now[settling[i]]; });
    going = going && for_each(faces.size(), run, [&](std::size_t f) {
              if (round + 1 < kRounds || planes[static_cast<Index>(f)] == nullptr) {
                normals[f] = faces.measured(now, f).normal;
              }
            });
  }
  return going;
}

}  // namespace burnish
