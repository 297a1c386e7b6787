#include "core/denoise/normal_patches.h"

#include <algorithm>

#include "core/mesh/curve.h"

namespace burnish {
namespace {

/// As they are when one part holds them all, otherwise along a curve through their first corners; when
/// stopped, any order.
std::vector<Index> order_of_faces(const Mesh& mesh, std::size_t parts, const RunControl& run) {
  const RunControl alone = run.on_one_thread();
  std::vector<Index> order(mesh.triangles.size());
  for_each(order.size(), run, [&](std::size_t f) { order[f] = static_cast<Index>(f); });
  if (parts <= 1) return order;
  const std::vector<Index> vertices = curve_order(mesh.positions, run);
  std::vector<Index> rank(vertices.size()), next(vertices.size() + 1);
  for_each(rank.size(), run, [&](std::size_t i) { rank[vertices[i]] = static_cast<Index>(i); });
  // Sorted by counting: bucket r + 1 begins where those of all ranks up to r end.
  for_each(order.size(), alone, [&](std::size_t f) { ++next[rank[mesh.triangles[f][0]] + 1]; });
  for_each(vertices.size(), alone, [&](std::size_t r) { next[r + 1] += next[r]; });
  if (run.stopped()) return order;
  for_each(order.size(), alone,
           [&](std::size_t f) { order[next[rank[mesh.triangles[f][0]]]++] = static_cast<Index>(f); });
  return order;
}

}  // namespace

NormalPatches::NormalPatches(const Surface& surface, const Faces& faces, const RunControl& run,
                             std::size_t most_faces)
    : faces_(faces),
      run_(run),
      patch_(faces),
      fields_(surface.mean_edge),
      parts_((faces.size() + most_faces - 1) / most_faces),
      order_(order_of_faces(surface.mesh, parts_, run)) {
  // Each part in the mesh's order, which the curve need not be.
  if (parts_ > 1) parallel_tasks(parts_, run, [&](std::size_t part) { std::ranges::sort(own(part)); });
}

std::span<Index> NormalPatches::own(std::size_t part) {
  const std::size_t begin = order_.size() * part / parts_, end = order_.size() * (part + 1) / parts_;
  return std::span(order_).subspan(begin, end - begin);
}

bool NormalPatches::take(std::size_t part) {
  if (taken_ == part) return true;
  taken_.reset();
  if (!patch_.surround(own(part), NormalFields::kRings)) return false;
  taken_ = part;
  return true;
}

bool NormalPatches::measure(std::span<const SimdVec3> positions, const Visit& visit) {
  Buffer<Seen> seen(whole_ ? 0 : faces_.size());
  if (parts_ > 1 && !whole_) {
    for (std::size_t part = 0; part < parts_; ++part) {
      if (!take(part) || !fields_.measure_differences(patch_, positions) || !gather(seen)) return false;
    }
    whole_ = fit(seen);
  }
  for (std::size_t part = 0; part < parts_; ++part) {
    if (!take(part) || !fields_.measure(patch_, positions)) return false;
    if (!whole_) {
      if (!gather(seen)) return false;
      whole_ = fit(seen);
    }
    if (!visit(fields_)) return false;
  }
  if (parts_ > 1) fields_.release();  // the mesh is large, and its vertices move next
  return !run_.stopped();
}

bool NormalPatches::gather(std::span<Seen> seen) const {
  return for_each(fields_.size(), run_, [&](std::size_t i) {
    seen[fields_.number(i)] = {fields_.differences(i), fields_.local_area(i)};
  });
}

/// Least squares over the fineness, in the order of the mesh. Where the triangles are all of one size it says
/// nothing, and the slope is less than the squares would have it.
NormalFields::Whole NormalPatches::fit(std::span<const Seen> seen) const {
  constexpr double kDoubt = 4e-3;  // variance of the fineness that counts half
  const auto mean = [&](auto&& value) {
    return parallel_sum(seen.size(), run_,
                        [&](std::size_t begin, std::size_t end) {
                          double part = 0;
                          for (std::size_t f = begin; f < end; ++f)
                            part += static_cast<double>(value(seen[f]));
                          return part;
                        }) /
           static_cast<double>(seen.size());
  };
  NormalFields::Whole whole;
  whole.local_area = static_cast<float>(mean([](const Seen& s) { return s.local_area; }));
  const auto fineness = [&](const Seen& s) { return static_cast<double>(whole.fineness(s.local_area)); };
  const double middle = mean(fineness);
  const double variance = mean([&](const Seen& s) {
    const double off = fineness(s) - middle;
    return off * off;
  });
  for (std::size_t k = 0; k < NormalFields::kGlobals; ++k) {
    const auto difference = [&](const Seen& s) { return static_cast<double>(s.differences[k]); };
    const double usual = mean(difference),
                 together = mean([&](const Seen&s) { return (fineness(s) - middle) * difference(s); });
    const double slope = together / (variance + kDoubt);
    whole.slope[k] = static_cast<float>(slope);
    whole.constant[k] = static_cast<float>(usual - slope * middle);
  }
  return whole;
}

}  // namespace burnish
