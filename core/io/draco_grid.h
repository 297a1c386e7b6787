// The lattice of values that a quantised Draco attribute can take, in the decoder's own float arithmetic.
#pragma once

#include <span>
#include <vector>

namespace burnish {

/// value[axis] = cell * range / (2^bits - 1) + origin[axis], with cell in 0 .. 2^bits - 1. Immutable.
class DracoGrid {
 public:
  static constexpr int kMostBits = 30;

  DracoGrid(int bits, std::vector<float> origin, float range);
  /// The smallest grid from `low` to `high`, which have one entry per axis. May be unusable when they are
  /// huge.
  static DracoGrid around(std::span<const float> low, std::span<const float> high, int bits);

  int bits() const { return bits_; }
  std::span<const float> origin() const { return origin_; }
  float range() const { return range_; }
  float cell_size() const { return cell_size_; }

  /// False when the grid's own numbers leave float; foreign files may hold anything.
  bool usable() const;
  bool holds(std::span<const float> low, std::span<const float> high) const;

  /// What a decoder reads after `value` was encoded.
  float written(std::size_t axis, float value) const;
  /// A value to encode so that a decoder reads `value`, which came from this grid. On grids finer than
  /// float's rounding that can be one of its neighbours.
  float encodable(std::size_t axis, float value) const;

  /// Grown by whole cells until it holds `low` to `high`; beyond 30 bits the cells grow instead.
  DracoGrid widened(std::span<const float> low, std::span<const float> high) const;

 private:
  float cell_of(std::size_t axis, float value) const;

  int bits_;
  std::vector<float> origin_;
  float range_;
  float last_cell_;       // 2^bits - 1, as float rounds it
  float cell_size_;       // the decoder's factor
  float cells_per_unit_;  // the encoder's factor
};

}  // namespace burnish
