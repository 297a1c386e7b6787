#include <cmath>
#include <limits>
#include <string>

#include "core/io/draco_document.h"

namespace burnish {
namespace {

using Attribute = draco::GeometryAttribute;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kDefaultSpeed = 5;

std::optional<int> requested_bits(const DracoOptions& options, Attribute::Type type) {
  switch (type) {
    case Attribute::POSITION:
      return options.position_bits;
    case Attribute::NORMAL:
      return options.normal_bits;
    case Attribute::TEX_COORD:
      return options.texture_coordinate_bits;
    case Attribute::COLOR:
      return options.color_bits;
    default:
      return options.generic_bits;
  }
}

Result<> check_range(const std::optional<int>& value, int low, int high, const char* name) {
  if (!value || (*value >= low && *value <= high)) return {};
  return Error{Cause::BadOption,
               std::string(name) + " must be " + std::to_string(low) + " to " + std::to_string(high) +
                   ", not " + std::to_string(*value),
               name};
}

Result<> check_options(const DracoOptions& options) {
  const std::pair<const char*, const std::optional<int>&> bits[] = {
      {"position_bits", options.position_bits},
      {"normal_bits", options.normal_bits},
      {"texture_coordinate_bits", options.texture_coordinate_bits},
      {"color_bits", options.color_bits},
      {"generic_bits", options.generic_bits}};
  for (const auto& [name, value] : bits) {
    if (auto ok = check_range(value, 0, DracoGrid::kMostBits, name); !ok) return ok;
  }
  if (options.normal_bits == 1) {
    return Error{Cause::BadOption, "normal_bits must be 0 or 2 to 30, not 1", "normal_bits"};
  }
  return check_range(options.speed, 0, 10, "speed");
}

/// Writes one mesh: moves its positions, settles how each attribute is coded, and calls the library.
class DracoWriter {
 public:
  DracoWriter(draco::Mesh& mesh, const MovedPositions& moved, DracoMethod method, const DracoOptions& options,
              const RunControl& run)
      : mesh_(mesh),
        moved_(moved),
        method_(method),
        options_(options),
        run_(run),
        position_id_(mesh.GetNamedAttributeId(Attribute::POSITION)),
        positions_(*mesh.attribute(position_id_)) {}

  Result<Encoded> write(std::span<const DracoCoding> inherited) {
    if (auto ok = check_shape(); !ok) return ok.error();
    if (auto ok = move_positions(); !ok) return ok.error();
    for (int id = 0; id < mesh_.num_attributes(); ++id) {
      auto coding = id == position_id_ ? code_positions(inherited[static_cast<std::size_t>(id)])
                                       : code_attribute(id, inherited[static_cast<std::size_t>(id)]);
      if (!coding) return coding.error();
      codings_.push_back(*std::move(coding));
    }
    if (auto ok = measure(); !ok) return ok.error();
    if (auto ok = call_library(); !ok) return ok.error();
    return std::move(encoded_);
  }

 private:
  struct Extent {
    std::vector<float> low, high;
    bool finite = true;
  };

  /// Sequential files with more points than triangle corners are refused by every decoder.
  Result<> check_shape() const {
    if (method_ == DracoMethod::Edgebreaker) return {};
    if (mesh_.num_points() <= 3 * std::uint64_t{mesh_.num_faces()}) return {};
    return Error{Cause::CannotEncode, "sequential Draco cannot hold " + std::to_string(mesh_.num_points()) +
                                          " vertices with " + std::to_string(mesh_.num_faces()) +
                                          " triangles: too many vertices are in no triangle"};
  }

  Result<> move_positions() {
    Index culprit = kNone;
    const bool done = for_each_index(moved_.original.size(), run_, [&](Index v) {
      const draco::AttributeValueIndex index = value_of(positions_, v);
      if (moved_.moved(v)) {
        const Vec3f p = to_float(moved_.at(v));
        positions_.SetAttributeValue(index, &p);
      }
      const auto p = positions_.GetValue<float, 3>(index);
      if (!is_finite(Vec3f{p[0], p[1], p[2]})) culprit = std::min(culprit, v);
    });
    if (!done) return run_.stop_error();
    if (culprit == kNone) return {};
    return Error{Cause::CannotEncode,
                 "vertex " + std::to_string(culprit) + " is beyond the range of Draco's 32 bit floats"};
  }

  /// Of the values that points use; a file may hold others.
  Result<Extent> extent_of(const draco::PointAttribute& attribute) const {
    const auto axes = static_cast<std::size_t>(attribute.num_components());
    Extent extent{std::vector<float>(axes, kInfinity), std::vector<float>(axes, -kInfinity)};
    std::vector<float> value(axes);
    const bool done = for_each_index(mesh_.num_points(), run_, [&](Index p) {
      attribute.GetMappedValue(draco::PointIndex(p), value.data());
      for (std::size_t axis = 0; axis < axes; ++axis) {
        if (!std::isfinite(value[axis])) extent.finite = false;
        extent.low[axis] = std::min(extent.low[axis], value[axis]);
        extent.high[axis] = std::max(extent.high[axis], value[axis]);
      }
    });
    if (!done) return run_.stop_error();
    return extent;
  }

  Result<DracoCoding> code_positions(const DracoCoding& inherited) {
    const int bits = options_.position_bits.value_or(inherited.bits);
    encoded_.position_bits = bits;
    if (bits == 0) return DracoCoding{};
    auto extent = extent_of(positions_);
    if (!extent) return extent.error();
    const bool keep = !options_.position_bits && inherited.grid && inherited.grid->usable();
    const bool widen = keep && !inherited.grid->holds(extent->low, extent->high);
    DracoGrid grid = widen  ? inherited.grid->widened(extent->low, extent->high)
                     : keep ? *inherited.grid
                            : DracoGrid::around(extent->low, extent->high, bits);
    if (!grid.usable()) {
      return Error{Cause::CannotEncode,
                   "the positions span more than a quantisation grid of floats can hold"};
    }
    if (widen) warn_about_widening(*inherited.grid, grid);
    if (keep && !widen && !settle_unmoved(grid)) return run_.stop_error();
    encoded_.position_bits = grid.bits();
    return DracoCoding{grid.bits(), std::move(grid)};
  }

  /// Each value once: a second time would look for the value that the first put in its place.
  bool settle_unmoved(const DracoGrid& grid) {
    std::vector<std::uint8_t> settled(positions_.size(), 0);
    return for_each_index(moved_.original.size(), run_, [&](Index v) {
      const draco::AttributeValueIndex index = value_of(positions_, v);
      if (moved_.moved(v) || settled[index.value()] != 0) return;
      settled[index.value()] = 1;
      settle(positions_, index, grid);
    });
  }

  static void settle(draco::PointAttribute& attribute, draco::AttributeValueIndex index,
                     const DracoGrid& grid) {
    auto* const value = reinterpret_cast<float*>(attribute.GetAddress(index));
    for (std::size_t axis = 0; axis < grid.origin().size(); ++axis) {
      value[axis] = grid.encodable(axis, value[axis]);
    }
  }

  void warn_about_widening(const DracoGrid& before, const DracoGrid& after) {
    std::uint32_t count = 0;
    Index first = kNone;
    for (Index v = 0; v < moved_.original.size(); ++v) {
      const auto p = positions_.GetValue<float, 3>(value_of(positions_, v));
      if (before.holds(p, p)) continue;
      first = std::min(first, v);
      ++count;
    }
    const bool coarser = after.cell_size() > before.cell_size() * 1.5f;
    encoded_.warnings.push_back({"quantisation_grid_widened",
                                 "the input's quantisation grid was widened from " +
                                     std::to_string(before.bits()) + " to " + std::to_string(after.bits()) +
                                     " bits" + (coarser ? ", with larger cells," : " of the same cell size") +
                                     " for vertices that left it; first: point " + std::to_string(first),
                                 count});
  }

  Result<DracoCoding> code_attribute(int id, const DracoCoding& inherited) {
    draco::PointAttribute& attribute = *mesh_.attribute(id);
    const bool normal = attribute.attribute_type() == Attribute::NORMAL;
    const std::optional<int> asked = requested_bits(options_, attribute.attribute_type());
    const int bits = asked.value_or(inherited.bits);
    if (bits == 0 || attribute.data_type() != draco::DT_FLOAT32) return DracoCoding{};
    if (normal && attribute.num_components() != 3) return DracoCoding{};
    auto extent = extent_of(attribute);
    if (!extent) return extent.error();
    if (!extent->finite) return DracoCoding{};  // NaN and infinity survive only as they are
    if (normal) return DracoCoding{std::max(bits, 2), std::nullopt};
    const bool keep = !asked && inherited.grid && inherited.grid->usable() &&
                      inherited.grid->holds(extent->low, extent->high);
    if (!keep) {
      DracoGrid grid = DracoGrid::around(extent->low, extent->high, bits);
      return grid.usable() ? DracoCoding{bits, std::move(grid)} : DracoCoding{};
    }
    const bool done = for_each_index(attribute.size(), run_, [&](Index value) {
      settle(attribute, draco::AttributeValueIndex(value), *inherited.grid);
    });
    if (!done) return run_.stop_error();
    return inherited;
  }

  /// The distance between what was wanted and what a decoder will read.
  Result<> measure() {
    const auto& grid = codings_[static_cast<std::size_t>(position_id_)].grid;
    double largest = 0;
    const bool done = for_each_index(moved_.original.size(), run_, [&](Index v) {
      const auto stored = positions_.GetValue<float, 3>(value_of(positions_, v));
      Vec3d read;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        read[axis] = grid ? grid->written(axis, stored[axis]) : stored[axis];
      }
      largest = std::max(largest, length(read - moved_.at(v)));
    });
    encoded_.quantisation_error = largest;
    return done ? Result<>{} : run_.stop_error();
  }

  Result<> call_library() {
    auto file = encode_with_library(mesh_, codings_, method_, options_.speed.value_or(kDefaultSpeed), run_);
    if (!file) return file.error();
    encoded_.bytes = std::move(file->bytes);
    encoded_.format = Format::Draco;
    encoded_.draco_method = method_;
    const bool reorders = method_ == DracoMethod::Edgebreaker;
    encoded_.vertices = reorders ? static_cast<std::uint32_t>(file->points) : mesh_.num_points();
    encoded_.triangles = reorders ? static_cast<std::uint32_t>(file->triangles) : mesh_.num_faces();
    if (reorders) warn_about_order(file->points, file->triangles);
    return {};
  }

  void warn_about_order(std::size_t points, std::size_t faces) {
    const auto of = [](std::size_t now, std::size_t before, const char* what) {
      return std::to_string(now) + " of " + std::to_string(before) + ' ' + what;
    };
    encoded_.warnings.push_back({"order_not_kept",
                                 "Edgebreaker reorders points and triangles, drops degenerate triangles and "
                                 "points without a triangle, "
                                 "and splits non-manifold edges; written: " +
                                     of(points, mesh_.num_points(), "points") + ", " +
                                     of(faces, mesh_.num_faces(), "triangles"),
                                 mesh_.num_points()});
  }

  draco::Mesh& mesh_;
  const MovedPositions& moved_;
  DracoMethod method_;
  const DracoOptions& options_;
  const RunControl& run_;
  int position_id_;
  draco::PointAttribute& positions_;
  std::vector<DracoCoding> codings_;
  Encoded encoded_;
};

}  // namespace

Result<Encoded> write_draco(draco::Mesh& mesh, const MovedPositions& moved,
                            std::span<const DracoCoding> inherited, DracoMethod method,
                            const DracoOptions& options, const RunControl& run) {
  if (auto ok = check_options(options); !ok) return ok.error();
  return DracoWriter(mesh, moved, method, options, run).write(inherited);
}

}  // namespace burnish
