#include "core/io/glb_compressed.h"

#include <algorithm>
#include <limits>

namespace burnish {
namespace {

/// A document's moved positions as far as they concern some of its vertices, which count from 0 here.
class PartOfMoved {
 public:
  PartOfMoved(const MovedPositions& all, Index first, Index count)
      : original_(all.original.subspan(first, count)), frame_(all.frame) {
    std::vector<Index> kept(all.weld.begin() + first, all.weld.begin() + first + count);
    std::ranges::sort(kept);
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    weld_.reserve(count);
    for (Index v = first; v < first + count; ++v) {
      const auto place = std::ranges::lower_bound(kept, all.weld[v]);
      weld_.push_back(static_cast<Index>(place - kept.begin()));
    }
    for (const Index v : kept) {
      before_.push_back(all.before[v]);
      after_.push_back(all.after[v]);
    }
  }

  MovedPositions view() const { return {original_, weld_, before_, after_, frame_}; }

 private:
  std::span<const Vec3d> original_;
  Frame frame_;
  std::vector<Index> weld_;
  std::vector<Vec3f> before_, after_;
};

void put_normals(const GlbDocument& document, Index vertices, const NormalRows& rows, draco::Mesh& mesh) {
  for (const GlbNormals& normals : document.normals()) {
    if (normals.vertices != vertices || rows.rows.empty()) continue;
    draco::PointAttribute& attribute = *mesh.attribute(normals.draco_attribute);
    for (Index point = 0; point < normals.count; ++point) {
      const Index row = rows.row_of_element[normals.first + point];
      if (rows.changed[row] != 0) attribute.SetAttributeValue(value_of(attribute, point), &rows.rows[row]);
    }
  }
}

/// What a reader will find.
Result<> read_back(GlbCompressed& result, const RunControl& run) {
  constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();
  const auto written = decode_draco(result.encoded.bytes, {kAny, kAny, kAny, ~0U, kAny}, run);
  if (auto ok = run.check(); !ok) return ok;
  if (!written) {
    return Error{Cause::CannotEncode, "what Draco wrote cannot be read: " + written.error().message};
  }
  const auto points = (*written)->positions();
  result.points = static_cast<std::uint32_t>(points.size());
  result.corners = static_cast<std::uint32_t>(3 * (*written)->triangles().size());
  result.low = result.high = points.front();
  for (const Vec3d& p : points) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      result.low[axis] = std::min(result.low[axis], p[axis]);
      result.high[axis] = std::max(result.high[axis], p[axis]);
    }
  }
  return {};
}

}  // namespace

Result<GlbCompressed> compress(const GlbDocument& document, Index vertices, const MovedPositions& moved,
                               const NormalRows& normals, const DracoOptions& options,
                               const RunControl& run) {
  const GlbVertices& held = document.vertices()[vertices];
  const auto method = held.ordered ? DracoMethod::Sequential : options.method.value_or(held.draco->method());
  GlbCompressed result;
  const auto written = without_exceptions(Cause::CannotEncode, [&]() -> Result<> {
    draco::Mesh mesh;
    mesh.Copy(held.draco->mesh());
    put_normals(document, vertices, normals, mesh);
    const PartOfMoved part(moved, held.first, held.count);
    auto encoded = write_draco(mesh, part.view(), held.draco->codings(), method, options, run);
    if (!encoded) return encoded.error();
    result.encoded = std::move(*encoded);
    return read_back(result, run);
  });
  if (!written) return written.error();
  return result;
}

}  // namespace burnish
