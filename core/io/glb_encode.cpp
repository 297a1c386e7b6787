#include <absl/strings/escaping.h>

#include <algorithm>
#include <limits>

#include "core/io/glb_compressed.h"
#include "core/io/glb_edits.h"

namespace burnish {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Of the numbers that a block of rows stores.
struct Extent {
  Vec3d low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  double error = 0;           ///< largest distance between what was wanted and what is written
  std::uint32_t clamped = 0;  ///< rows beyond what their integers hold
  Index culprit = kNone;      ///< a row beyond float
  bool moved = false;

  void add(const Extent& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
    error = std::max(error, other.error);
    clamped += other.clamped;
    culprit = std::min(culprit, other.culprit);
    moved |= other.moved;
  }
};

bool asks_for_anything(const DracoOptions& o) {
  return o.method || o.position_bits || o.normal_bits || o.texture_coordinate_bits || o.color_bits ||
         o.generic_bits || o.speed;
}

/// Writes and reads one row of positions.
class RowWriter {
 public:
  explicit RowWriter(const GlbAccessor& accessor)
      : component_(accessor.component),
        scale_(accessor.normalized ? full_scale(accessor.component) : 1),
        bytes_(component_bytes(accessor.component)) {}

  void write(char* at, const Vec3d& position) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      write_component(at + axis * bytes_, component_, position[axis] * scale_);
    }
  }
  /// As it is stored: integers as they are.
  Vec3d stored(const char* at) const {
    Vec3d value;
    for (std::size_t axis = 0; axis < 3; ++axis) value[axis] = read_component(at + axis * bytes_, component_);
    return value;
  }
  Vec3d meant(const Vec3d& stored) const { return stored * (1 / scale_); }
  /// Whether rounding alone stands between the two.
  bool holds(const Vec3d& stored, const Vec3d& position) const {
    if (component_ == GlbComponent::Float) return true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(std::abs(stored[axis] - position[axis] * scale_) <= 0.5)) return false;
    }
    return true;
  }

 private:
  GlbComponent component_;
  double scale_;
  std::size_t bytes_;
};

class GlbWriter {
 public:
  GlbWriter(const GlbDocument& document, const MovedPositions& moved, const OutputOptions& options,
            const RunControl& run)
      : document_(document), moved_(moved), options_(options), run_(run), buffers_(document.file()) {
    encoded_.format = Format::Glb;
  }

  Result<Encoded> write() {
    auto normals = document_.moved_normals(moved_, run_);
    if (!normals) return normals.error();
    for (Index i = 0; i < document_.vertices().size(); ++i) {
      const bool compressed = document_.vertices()[i].draco != nullptr;
      if (auto ok = compressed ? move_compressed(i, *normals) : move_rows(i); !ok) return ok.error();
    }
    for (const GlbNormals& each : document_.normals()) {
      if (each.draco_attribute >= 0) continue;
      if (auto ok = turn_normals(each, *normals); !ok) return ok.error();
    }
    if (auto ok = replace_views(document_.file(), std::move(replacements_), buffers_, edits_); !ok) {
      return ok.error();
    }
    if (any_moved_) warn_of_what_stays();
    return assemble();
  }

 private:
  bool moves(const GlbVertices& vertices) const {
    for (Index v = vertices.first; v < vertices.first + vertices.count; ++v) {
      if (moved_.moved(v)) return true;
    }
    return false;
  }

  Result<> move_rows(Index index) {
    const GlbVertices& vertices = document_.vertices()[index];
    if (!moves(vertices)) return {};
    any_moved_ = true;
    const GlbAccessor& rows = vertices.positions;
    char* const data = buffers_.change(rows.buffer).data() + rows.begin;
    const RowWriter writer(rows);
    std::vector<Extent> extents(block_count(vertices.count));
    const bool done = parallel_for(vertices.count, run_, [&](std::size_t begin, std::size_t end) {
      Extent& extent = extents[begin / block_size(vertices.count)];
      for (std::size_t row = begin; row < end; ++row) {
        move_row(data + row * rows.stride, static_cast<Index>(vertices.first + row), writer, extent);
      }
    });
    if (!done) return run_.stop_error();
    Extent all;
    for (const Extent& extent : extents) all.add(extent);
    if (all.culprit != kNone) {
      return Error{Cause::CannotEncode,
                   document_.vertex_place(all.culprit) + " is beyond the range of 32 bit floats"};
    }
    if (all.clamped > 0) {
      warn("quantisation_range_left",
           document_.place_of(document_.primitives()[vertices.primitive]) +
               ": vertices beyond what the integers of its positions hold were held back",
           all.clamped);
    }
    encoded_.quantisation_error = std::max(encoded_.quantisation_error, all.error);
    edits_.accessors[rows.number] = {{}, all.low, all.high};
    return {};
  }

  void move_row(char* at, Index vertex, const RowWriter& writer, Extent& extent) const {
    if (moved_.moved(vertex)) {
      const Vec3d wanted = moved_.at(vertex);
      writer.write(at, wanted);
      const Vec3d stored = writer.stored(at);
      if (!is_finite(stored)) extent.culprit = std::min(extent.culprit, vertex);
      extent.error = std::max(extent.error, length(writer.meant(stored) - wanted));
      extent.clamped += static_cast<std::uint32_t>(!writer.holds(stored, wanted));
    }
    const Vec3d stored = writer.stored(at);
    extent.add({.low = stored, .high = stored});
  }

  Result<> turn_normals(const GlbNormals& normals, const NormalRows& rows) {
    if (normals.shared) return {};
    bool any = false;
    for (Index i = 0; i < normals.count && !any; ++i) {
      any = rows.changed[rows.row_of_element[normals.first + i]] != 0;
    }
    if (!any) return {};
    const GlbAccessor& accessor = normals.accessor;
    char* const data = buffers_.change(accessor.buffer).data() + accessor.begin;
    const RowWriter writer(accessor);
    const bool done = for_each(normals.count, run_, [&](std::size_t i) {
      const Index row = rows.row_of_element[normals.first + i];
      if (rows.changed[row] != 0) writer.write(data + i * accessor.stride, to_double(rows.rows[row]));
    });
    return done ? Result<>{} : run_.stop_error();
  }

  Result<> move_compressed(Index index, const NormalRows& normals) {
    const GlbVertices& vertices = document_.vertices()[index];
    const bool moved = moves(vertices);
    if (!moved && !asks_for_anything(options_.draco)) return count_compressed(vertices, nullptr);
    any_moved_ |= moved;
    auto written = compress(document_, index, moved_, normals, options_.draco, run_);
    if (!written) {
      Error error = written.error();
      error.message = document_.place_of(document_.primitives()[vertices.primitive]) + ": " + error.message;
      return error;
    }
    if (auto ok = count_compressed(vertices, &*written); !ok) return ok;
    for (const Warning& warning : written->encoded.warnings)
      warn(warning.code, warning.message, warning.count);
    encoded_.quantisation_error = std::max(encoded_.quantisation_error, written->encoded.quantisation_error);
    replacements_.push_back({vertices.view, vertices.place, std::move(written->encoded.bytes)});
    return {};
  }

  /// Counts and extents in the JSON, and in the report. Null: the bytes stay.
  Result<> count_compressed(const GlbVertices& vertices, const GlbCompressed* written) {
    const auto corners = static_cast<std::uint32_t>(3 * vertices.draco->triangles().size());
    const std::uint32_t points_now = written != nullptr ? written->points : vertices.count;
    const std::uint32_t corners_now = written != nullptr ? written->corners : corners;
    for (const auto& [accessors, count] :
         {std::pair{&vertices.counting, points_now}, std::pair{&vertices.counting_corners, corners_now}}) {
      for (const Index number : *accessors) {
        if (auto ok = set_count(number, count); !ok) return ok;
      }
    }
    fewer_vertices_ += std::int64_t{vertices.count} - points_now;
    fewer_triangles_ += (std::int64_t{corners} - corners_now) / 3;
    note_coding(vertices, written);
    if (written == nullptr) return {};
    edits_.accessors[vertices.positions.number].low = written->low;
    edits_.accessors[vertices.positions.number].high = written->high;
    return {};
  }

  Result<> set_count(Index accessor, std::uint32_t count) {
    std::optional<std::uint64_t>& held = edits_.accessors[accessor].count;
    if (held && *held != count) {
      return Error{Cause::CannotEncode, "accessors[" + std::to_string(accessor) +
                                            "] counts the vertices of two compressed meshes, which have "
                                            "different counts after writing"};
    }
    held = count;
    return {};
  }

  /// The report has room for one: the coarsest grid, and its method.
  void note_coding(const GlbVertices& vertices, const GlbCompressed* written) {
    int bits = 0;
    DracoMethod method = vertices.draco->method();
    if (written != nullptr) {
      bits = written->encoded.position_bits;
      method = written->encoded.draco_method.value_or(method);
    } else {
      const int position = vertices.draco->mesh().GetNamedAttributeId(draco::GeometryAttribute::POSITION);
      bits = vertices.draco->codings()[static_cast<std::size_t>(position)].bits;
    }
    const bool coarser = bits > 0 && (encoded_.position_bits == 0 || bits < encoded_.position_bits);
    if (encoded_.draco_method && !coarser) return;
    encoded_.draco_method = method;
    encoded_.position_bits = bits;
  }

  /// One warning of a kind: the first, with the sum of the counts.
  void warn(const std::string& code, const std::string& message, std::uint32_t count) {
    const auto known = std::ranges::find(encoded_.warnings, code, &Warning::code);
    if (known == encoded_.warnings.end()) {
      encoded_.warnings.push_back({code, message, count});
    } else {
      known->count += count;
    }
  }

  void warn_of_what_stays() {
    const GlbPassedOver& passed = document_.passed_over();
    if (passed.primitives > 0) {
      warn("primitives_not_smoothed",
           "points, lines and primitives without positions are those of the input; first: " +
               passed.first_primitive,
           passed.primitives);
    }
    if (passed.tangents > 0) {
      warn("tangents_kept", "tangents are those of the input; first: " + passed.first_tangents,
           passed.tangents);
    }
    if (passed.targets > 0) {
      warn("morph_targets_kept",
           "morph targets are those of the input: offsets, now from the moved positions; first: " +
               passed.first_targets,
           passed.targets);
    }
    const auto shared = static_cast<std::uint32_t>(
        std::ranges::count_if(document_.normals(), [](const GlbNormals& n) { return n.shared; }));
    if (passed.normals + shared > 0) {
      warn("normals_not_recomputed",
           passed.normals > 0 ? "normals in a form that is not recomputed are those of the input; first: " +
                                    passed.first_normals
                              : "normals that several sets of positions share are those of the input",
           passed.normals + shared);
    }
  }

  Result<Encoded> assemble() {
    const GlbFile& file = document_.file();
    GlbContainer parts = file.container();
    for (const auto& [buffer, bytes] : buffers_.changed()) {
      if (!file.in_json(buffer)) continue;
      GlbEdits::Buffer& edit = edits_.buffers[buffer];
      edit.length = bytes.size();
      edit.uri = file.uri_head(buffer) + absl::Base64Escape(bytes);
    }
    if (auto ok = run_.check(); !ok) return ok.error();
    const std::string json = edits_.apply(file.json_text());
    if (json != file.json_text()) parts.json = json;
    std::string bin;
    for (const auto& [buffer, bytes] : buffers_.changed()) {
      if (file.in_json(buffer)) continue;
      // Behind the buffer's own bytes the chunk is filled up.
      const bool same_size = bytes.size() == file.buffer(buffer).size();
      bin = bytes;
      if (same_size) bin += parts.bin->substr(bytes.size());
      parts.bin = bin;
    }
    auto written = write_glb_container(parts);
    if (!written) return written.error();
    if (run_.stopped()) return run_.stop_error();
    encoded_.bytes = std::move(*written);
    if (encoded_.draco_method) {
      const auto less = [](std::size_t count, std::int64_t by) {
        return static_cast<std::uint32_t>(static_cast<std::int64_t>(count) - by);
      };
      encoded_.vertices = less(document_.positions().size(), fewer_vertices_);
      encoded_.triangles = less(document_.triangles().size(), fewer_triangles_);
    }
    return std::move(encoded_);
  }

  const GlbDocument& document_;
  const MovedPositions& moved_;
  const OutputOptions& options_;
  const RunControl& run_;
  GlbBuffers buffers_;
  GlbEdits edits_;
  std::vector<GlbReplacement> replacements_;
  std::int64_t fewer_vertices_ = 0, fewer_triangles_ = 0;
  bool any_moved_ = false;
  Encoded encoded_;
};

}  // namespace

Result<Encoded> GlbDocument::encode_same(const MovedPositions& moved, const OutputOptions& options,
                                         const RunControl& run) const {
  return GlbWriter(*this, moved, options, run).write();
}

}  // namespace burnish
