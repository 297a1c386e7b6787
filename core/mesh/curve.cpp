#include "core/mesh/curve.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <numeric>

#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr std::size_t kBits = 10, kBuckets = std::size_t{1} << kBits;
/// So many in a cell may stay in any order.
constexpr std::size_t kFew = 32;

struct Placed {
  std::uint32_t cell;  // number along the curve
  Index point;
};

/// Every third bit of the result is a bit of `x`, which has ten.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000FFU;
  x = (x | x << 8) & 0x0300F00FU;
  x = (x | x << 4) & 0x030C30C3U;
  return (x | x << 2) & 0x09249249U;
}

class CurveSort {
 public:
  CurveSort(std::span<const Vec3f> points, const RunControl& run) : points_(points), run_(run) {
    items_.resize(points.size());
    for_each(items_.size(), run_, [&](std::size_t i) { items_[i].point = static_cast<Index>(i); });
  }

  std::vector<Index> sorted() {
    if (!run_.stopped()) sort(0, items_.size());
    std::vector<Index> order(items_.size());
    for_each(order.size(), run_, [&](std::size_t i) { order[i] = items_[i].point; });
    return order;
  }

 private:
  void sort(std::size_t begin, std::size_t end) {
    if (run_.stopped() || !place(begin, end)) return;
    const auto first = items_.begin() + static_cast<std::ptrdiff_t>(begin),
               last = items_.begin() + static_cast<std::ptrdiff_t>(end);
    if (std::is_sorted(first, last, [](const Placed& a, const Placed& b) { return a.cell < b.cell; })) {
    } else if (end - begin < kBuckets) {
      std::sort(items_.begin() + static_cast<std::ptrdiff_t>(begin),
                items_.begin() + static_cast<std::ptrdiff_t>(end), [](const Placed& a, const Placed& b) {
                  return a.cell != b.cell ? a.cell < b.cell : a.point < b.point;
                });
    } else {
      sort_by_digits(begin, end);
    }
    for (std::size_t i = begin, j = begin; i < end; i = j) {
      while (++j < end && items_[j].cell == items_[i].cell) {
      }
      if (j - i > kFew) sort(i, j);
    }
  }

  /// Numbers the cells. False when all points are at one place, as near as float tells cells apart.
  bool place(std::size_t begin, std::size_t end) {
    Vec3f low = points_[items_[begin].point], high = low;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f& p = points_[items_[i].point];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    const Vec3f extent = high - low;
    const float longest = std::max({extent.x, extent.y, extent.z}), per_cell = (kBuckets - 0.5F) / longest;
    if (!(longest > kBuckets * FLT_MIN)) return false;
    parallel_for(end - begin, run_, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = begin + from; i < begin + to; ++i) {
        const Vec3f at = (points_[items_[i].point] - low) * per_cell;
        items_[i].cell = spread(static_cast<std::uint32_t>(at.x)) << 2 |
                         spread(static_cast<std::uint32_t>(at.y)) << 1 |
                         spread(static_cast<std::uint32_t>(at.z));
      }
    });
    return true;
  }

  void sort_by_digits(std::size_t begin, std::size_t end) {
    spare_.resize(items_.size());
    std::array<std::array<Index, kBuckets>, 3> starts{};
    const RunControl alone = run_.on_one_thread();
    for_each(end - begin, alone, [&](std::size_t i) {
      for (std::size_t digit = 0; digit < 3; ++digit)
        ++starts[digit][items_[begin + i].cell >> kBits * digit & (kBuckets - 1)];
    });
    for (std::size_t digit = 0; digit < 3; ++digit) {
      auto& next = starts[digit];
      std::exclusive_scan(next.begin(), next.end(), next.begin(), static_cast<Index>(begin));
      for_each(end - begin, alone, [&](std::size_t i) {
        const Placed item = items_[begin + i];
        spare_[next[item.cell >> kBits * digit & (kBuckets - 1)]++] = item;
      });
      items_.swap(spare_);
    }
    // An odd number of turns: what this range holds is in the other array now, and the rest must follow.
    std::copy(items_.begin() + static_cast<std::ptrdiff_t>(begin),
              items_.begin() + static_cast<std::ptrdiff_t>(end),
              spare_.begin() + static_cast<std::ptrdiff_t>(begin));
    items_.swap(spare_);
  }

  std::span<const Vec3f> points_;
  const RunControl& run_;
  std::vector<Placed> items_, spare_;
};

}  // namespace

std::vector<Index> curve_order(std::span<const Vec3f> points, const RunControl& run) {
  if (points.empty()) return {};
  return CurveSort(points, run).sorted();
}

}  // namespace burnish
