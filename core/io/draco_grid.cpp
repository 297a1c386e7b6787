#include "core/io/draco_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace burnish {
namespace {

float last_bit(float value) {
  const float size = std::abs(value);
  return std::nextafter(size, std::numeric_limits<float>::infinity()) - size;
}

constexpr double last_cell(int bits) { return static_cast<double>((1u << bits) - 1); }

}  // namespace

DracoGrid::DracoGrid(int bits, std::vector<float> origin, float range)
    : bits_(bits),
      origin_(std::move(origin)),
      range_(range),
      last_cell_(static_cast<float>((1u << bits) - 1)),
      cell_size_(range / last_cell_),
      cells_per_unit_(last_cell_ / range) {}

DracoGrid DracoGrid::around(std::span<const float> low, std::span<const float> high, int bits) {
  float range = 0;
  for (std::size_t axis = 0; axis < low.size(); ++axis) range = std::max(range, high[axis] - low[axis]);
  if (range == 0) range = 1;
  // Cells below the smallest normal float would make the encoder's factor infinite.
  const float least = std::ldexp(std::numeric_limits<float>::min(), bits + 1);
  return {bits, std::vector<float>(low.begin(), low.end()), std::max(range, least)};
}

bool DracoGrid::usable() const {
  return std::isfinite(range_) && cell_size_ >= std::numeric_limits<float>::min() &&
         std::isfinite(cells_per_unit_) &&
         std::all_of(origin_.begin(), origin_.end(), [this](float o) { return std::isfinite(o + range_); });
}

float DracoGrid::cell_of(std::size_t axis, float value) const {
  return std::floor((value - origin_[axis]) * cells_per_unit_ + 0.5f);
}

bool DracoGrid::holds(std::span<const float> low, std::span<const float> high) const {
  const float top_cell =
      std::floor(last_cell_ + 0.5f);  // on fine grids one more than the last: encoders write it
  for (std::size_t axis = 0; axis < origin_.size(); ++axis) {
    // Rounding may take a value that came from the top cell to one beyond it.
    const float top = top_cell * cell_size_ + origin_[axis];
    if (!(cell_of(axis, low[axis]) >= 0)) return false;
    if (!(cell_of(axis, high[axis]) <= top_cell || high[axis] <= top)) return false;
  }
  return true;
}

float DracoGrid::written(std::size_t axis, float value) const {
  return cell_of(axis, value) * cell_size_ + origin_[axis];
}

float DracoGrid::encodable(std::size_t axis, float value) const {
  if (written(axis, value) == value) return value;
  // Some value nearby does: the one that the file's encoder was given. It is within two cells, or within the
  // rounding of its distance to the origin.
  const float step = std::max({cell_size_ / 4, last_bit(value), last_bit(value - origin_[axis]) / 2});
  for (int steps = 1; steps <= 8; ++steps) {
    const float distance = static_cast<float>(steps) * step;
    if (written(axis, value + distance) == value) return value + distance;
    if (written(axis, value - distance) == value) return value - distance;
  }
  return value;
}

DracoGrid DracoGrid::widened(std::span<const float> low, std::span<const float> high) const {
  const double cell = cell_size_;
  std::vector<float> origin = origin_;
  double needed = last_cell(bits_);
  for (std::size_t axis = 0; axis < origin.size(); ++axis) {
    const double below = std::max(0.0, std::ceil((double{origin[axis]} - low[axis]) / cell));
    origin[axis] = static_cast<float>(origin[axis] - below * cell);
    needed = std::max(needed, std::ceil((double{high[axis]} - origin[axis]) / cell));
  }
  int bits = bits_;
  while (bits < kMostBits && last_cell(bits) < needed) ++bits;
  if (last_cell(bits) >= needed) {
    DracoGrid grid(bits, std::move(origin), static_cast<float>(cell * last_cell(bits)));
    if (grid.usable() && grid.holds(low, high)) return grid;
  }
  return around(low, high, kMostBits);
}

}  // namespace burnish
