// The rows of a PLY file: every byte is accounted for before anything believes the header's counts.
#include <algorithm>
#include <cmath>

#include "core/io/pins.h"
#include "core/io/ply_document.h"
#include "core/io/ply_source.h"
#include "core/io/polygons.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

std::string row_name(const PlyElement& element, std::uint64_t row) {
  const std::string name = quote(element.name);
  return name.substr(1, name.size() - 2) + ' ' + std::to_string(row);
}

}  // namespace

class PlyReader {
 public:
  PlyReader(std::string_view bytes, PlyHeader header, const Limits& limits, const RunControl& run)
      : bytes_(bytes),
        limits_(limits),
        run_(run),
        document_(std::make_unique<PlyDocument>(bytes, std::move(header))),
        header_(document_->header_) {}

  Result<std::unique_ptr<Document>> read() {
    const auto layout = find_ply_layout(header_, limits_);
    if (!layout) return layout.error();
    document_->vertex_element_ = layout->vertices;
    document_->face_element_ = layout->faces;
    axes_ = layout->axes;
    if (header_.encoding == PlyEncoding::Text) {
      if (auto ok = check_line_lengths(bytes_, header_.end, limits_); !ok) return ok.error();
    }
    const auto rows = with_ply_source(bytes_, header_.end, header_.encoding,
                                      [&](auto& source) { return read_elements(source); });
    if (!rows) return rows.error();
    if (document_->triangles_.empty()) return Error{Cause::EmptyMesh, "the PLY file has no face"};
    return std::unique_ptr<Document>(std::move(document_));
  }

 private:
  template <class Source>
  Result<> read_elements(Source& source) {
    for (std::size_t e = 0; e < header_.elements.size(); ++e) {
      const PlyElement& element = header_.elements[e];
      const std::uint64_t begin = source.offset();
      document_->begins_.push_back(begin);
      // A count that the rest of the file cannot hold allocates nothing.
      const std::uint64_t rest = bytes_.size() - begin + (header_.encoding == PlyEncoding::Text ? 1 : 0);
      if (element.least_bytes > 0 && rest / element.least_bytes < element.count) {
        return Error{Cause::MalformedMesh, "the element " + quote(element.name) + " has " +
                                               std::to_string(element.count) + " rows, of which the file" +
                                               " ends before the last" + source.place(bytes_.size())};
      }
      Result<> ok;
      if (e == document_->vertex_element_)
        ok = read_vertices(source, element);
      else if (e == document_->face_element_)
        ok = read_faces(source, element);
      else if (element.name == "tristrips")
        ok = read_strips(source, element);
      else
        ok = skip(source, element);
      if (!ok) return ok;
    }
    for (const Triangle& strip : strips_) document_->triangles_.push_back(strip);
    return run_.check();
  }

  /// Goes through the rows of an element; each(row) goes through one.
  template <class Each>
  Result<> each_row(const PlyElement& element, Each&& each) {
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (row % kBlockSize == 0 && run_.stopped()) return run_.stop_error();
      if (auto ok = each(row); !ok) return ok;
    }
    return {};
  }

  template <class Source>
  Result<> skip(Source& source, const PlyElement& element) {
    if (element.properties.empty()) return {};
    if (!element.has_list) {
      if constexpr (std::is_same_v<Source, PlyBinarySource>) {
        return source.skip(PlyType::Uint8, element.count * element.least_bytes)
                   ? Result<>{}
                   : source.problem("the element " + quote(element.name));
      }
    }
    return each_row(element, [&](std::uint64_t row) -> Result<> {
      std::int64_t count = 0;
      const bool fits = read_ply_row(
          source, element, count,
          [&](const PlyProperty& property, std::uint64_t n) { return source.skip(property.type, n); });
      return fits ? Result<>{} : bad_row(source, element, row, count);
    });
  }

  template <class Source>
  Result<> read_vertices(Source& source, const PlyElement& element) {
    constexpr bool kText = std::is_same_v<Source, PlyTextSource>;
    document_->positions_.resize(element.count);
    if (kText || element.has_list) document_->vertex_rows_.resize(element.count);
    return each_row(element, [&](std::uint64_t row) -> Result<> {
      const std::uint64_t begin = source.offset();
      if (!document_->vertex_rows_.empty()) document_->vertex_rows_[row] = begin;
      Vec3d& position = document_->positions_[row];
      std::int64_t count = 0;
      const bool fits =
          read_ply_row(source, element, count, [&](const PlyProperty& property, std::uint64_t n) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
              if (&property == axes_[axis]) return source.real(property.type, position[axis]);
            }
            return source.skip(property.type, n);
          });
      if (!fits) return bad_row(source, element, row, count);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (std::abs(position[axis]) <= kLargestCoordinate) continue;
        const bool finite = std::isfinite(position[axis]);
        return Error{Cause::NonFinitePosition,
                     "vertex " + std::to_string(row) + ": coordinate " + "xyz"[axis] +
                         (finite ? " is beyond 1e60" : " is not a finite number") + source.place(begin)};
      }
      return {};
    });
  }

  template <class Source>
  Result<> read_faces(Source& source, const PlyElement& element) {
    const PlyProperty* const indices = ply_vertex_indices(element);
    document_->triangles_.reserve(element.count);
    std::vector<Index> corners;
    auto ok = each_row(element, [&](std::uint64_t row) -> Result<> {
      const std::uint64_t begin = source.offset();
      if (read_plain_triangle(source, element)) return {};
      if (auto read = read_indices(source, element, *indices, row, corners, false); !read) return read;
      if (corners.size() < 3) {
        return Error{Cause::MalformedMesh, row_name(element, row) + " has " + std::to_string(corners.size()) +
                                               " corners; it needs at least 3" + source.place(begin)};
      }
      if (document_->triangles_.size() + corners.size() - 2 > limits_.max_triangles)
        return ply_too_large(element, "triangles", limits_.max_triangles, "max-triangles");
      add_fan(corners, static_cast<Index>(row), document_->triangles_, document_->face_of_triangle_);
      return {};
    });
    document_->face_triangles_ = document_->triangles_.size();
    return ok;
  }

  /// A count of one byte and three indices of 32 bits, and nothing else: what nearly all binary files hold.
  bool read_plain_triangle(PlyTextSource&, const PlyElement&) { return false; }
  bool read_plain_triangle(PlyBinarySource& source, const PlyElement& element) {
    constexpr std::uint64_t kBytes = 13;
    const PlyProperty& list = element.properties.front();
    const bool plain = element.properties.size() == 1 && size_of(*list.count_type) == 1 &&
                       size_of(list.type) == 4 && document_->face_of_triangle_.empty();
    const std::uint64_t at = source.offset();
    if (!plain || bytes_.size() - at < kBytes || bytes_[at] != 3 ||
        document_->triangles_.size() >= limits_.max_triangles)
      return false;
    Triangle corners;
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = load_number<std::uint32_t>(bytes_.data() + at + 1 + 4 * c, header_.encoding);
      if (corners[c] >= document_->vertices().count || corners[c] > 0x7fffffffU) return false;
    }
    document_->triangles_.push_back(corners);
    return source.skip(PlyType::Uint8, kBytes);
  }

  /// Fills `corners` with the list of a row. A strip may hold -1, which becomes kNone.
  template <class Source>
  Result<> read_indices(Source& source, const PlyElement& element, const PlyProperty& indices,
                        std::uint64_t row, std::vector<Index>& corners, bool strip) {
    corners.clear();
    std::int64_t count = 0, value = 0;
    std::uint64_t culprit = 0;
    bool outside = false;
    const auto vertices = static_cast<std::int64_t>(document_->vertices().count);
    const bool fits = read_ply_row(source, element, count, [&](const PlyProperty& property, std::uint64_t n) {
      if (&property != &indices) return source.skip(property.type, n);
      for (std::uint64_t i = 0; i < n; ++i) {
        culprit = source.offset();
        if (!source.integer(property.type, value)) return false;
        const bool restart = strip && value == -1;
        outside = !restart && (value < 0 || value >= vertices);
        if (outside) return false;
        corners.push_back(restart ? kNone : static_cast<Index>(value));
      }
      return true;
    });
    if (outside) {
      return Error{Cause::IndexOutOfRange, row_name(element, row) + " uses vertex " + std::to_string(value) +
                                               " of " + std::to_string(vertices) + source.place(culprit)};
    }
    return fits ? Result<>{} : bad_row(source, element, row, count);
  }

  template <class Source>
  Result<> read_strips(Source& source, const PlyElement& element) {
    const PlyProperty* const indices = ply_vertex_indices(element);
    std::vector<Index> corners;
    return each_row(element, [&](std::uint64_t row) -> Result<> {
      if (auto read = read_indices(source, element, *indices, row, corners, true); !read) return read;
      std::size_t begin = 0;
      for (std::size_t c = 0; c < corners.size(); ++c) {
        if (corners[c] == kNone) begin = c + 1;
        if (c < begin + 2) continue;
        // Every other triangle is turned round; those that only lead to the next strip have no area.
        const bool turned = (c - begin) % 2 != 0;
        const Triangle t{corners[turned ? c - 1 : c - 2], corners[turned ? c - 2 : c - 1], corners[c]};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) strips_.push_back(t);
        if (document_->triangles_.size() + strips_.size() > limits_.max_triangles)
          return ply_too_large(element, "triangles", limits_.max_triangles, "max-triangles");
      }
      return {};
    });
  }

  template <class Source>
  Error bad_row(Source& source, const PlyElement& element, std::uint64_t row, std::int64_t count) {
    if (count < 0) {
      return {Cause::MalformedMesh, row_name(element, row) + " has a list of " + std::to_string(count) +
                                        " items" + source.place(source.offset())};
    }
    return source.problem(row_name(element, row));
  }

  std::string_view bytes_;
  const Limits& limits_;
  const RunControl& run_;
  std::unique_ptr<PlyDocument> document_;
  const PlyHeader& header_;
  std::array<const PlyProperty*, 3> axes_{};
  std::vector<Triangle> strips_;
};

Result<std::unique_ptr<Document>> decode_ply(std::string_view bytes, const Limits& limits,
                                             const RunControl& run) {
  auto header = read_ply_header(bytes, limits);
  if (!header) return header.error();
  return PlyReader(bytes, std::move(*header), limits, run).read();
}

}  // namespace burnish
