// A cascade of networks, each of which sees the mesh that the one before it made: predicted face normals, and
// vertices moved to fit.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/denoise/normal_network.h"
#include "core/denoise/normal_patches.h"

namespace burnish {

struct CascadeOptions {
  std::uint32_t vertex_steps = 20;  ///< steps of the vertices per stage, at least 1
  /// Rings over which what the steps took away is averaged and given back, so that the surface stays where
  /// the scan has it and only the noise goes: of a surface that is curved all over, and of one that is mostly
  /// flat, as machined parts are. Between the two by the share of edges that do not bend. 0 and 0 give
  /// nothing back.
  std::uint32_t give_back = 3, give_back_flat = 30;
  std::uint32_t facet_steps = 10;  ///< of finish(), see smooth_facets()
  std::uint32_t plane_steps = 20;  ///< of finish(), see settle_on_planes()
  bool only_outliers = false;  ///< of finish(): vertices that do not stand out stay where the scan has them
};

class NormalCascade {
 public:
  /// Reads the surface's positions, which must stay as they are meanwhile, as the scan. At least one network;
  /// stages beyond the last use the last. Everything given must outlive the cascade.
  NormalCascade(const Surface& surface, std::span<const std::uint8_t> movable, const CascadeOptions& options,
                std::span<const NormalNetwork> networks, const RunControl& run);

  /// Where the next stage takes the vertices: see positions(). False when stopped.
  bool advance(std::span<const SimdVec3> from);
  /// After the last stage: smooths facets, settles on planes and takes back what these turned too far, or
  /// leaves vertices at home that were never off. False when stopped.
  bool finish();
  /// On from there, by `share` of a step towards a surface that is smoother than learned. False when stopped.
  bool go_beyond(float share);
  /// Back by 1 - share of the way from the scan. False when stopped.
  bool stay_behind(float share);
  /// Takes vertices back where a triangle that agreed with its predicted normal in the scan no longer does in
  /// `positions`. False when stopped.
  bool unflip(std::span<SimdVec3> positions) const;

  std::span<const SimdVec3> positions() const { return now_; }
  bool movable(std::size_t v) const { return movable_[v] != 0; }

 private:
  SimdVec3 home(std::size_t v) const { return SimdVec3(surface_.mesh.positions[v]); }
  SimdVec3 normal_at(std::size_t v) const;
  bool fit(Buffer<SimdVec3>& normals, std::uint32_t steps);
  bool unfold();
  bool give_back();
  bool sharpen();
  bool keep_exact(std::span<const std::uint8_t> outlier);
  bool average_over_rings(std::uint32_t rings, Buffer<float>& heights, Buffer<float>& next) const;

  const Surface& surface_;
  const std::span<const std::uint8_t> movable_;
  const CascadeOptions& options_;
  const std::span<const NormalNetwork> networks_;
  const RunControl& run_;
  Faces faces_;
  std::optional<NormalPatches> patches_;  // only while normals are measured: finish() needs the memory
  Buffer<SimdVec3> predicted_, now_, next_;
  std::size_t stage_ = 0;
};

}  // namespace burnish
