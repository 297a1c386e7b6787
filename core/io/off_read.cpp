#include <algorithm>
#include <cmath>

#include "core/io/off_document.h"
#include "core/io/pins.h"
#include "core/io/polygons.h"
#include "core/io/text_scan.h"
#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr std::uint64_t kLeastVertexBytes = 6, kLeastFaceBytes = 8;  // "0 0 0\n", "3 0 1 2\n"

}  // namespace

class OffReader {
 public:
  OffReader(std::string_view text, const Limits& limits, const RunControl& run)
      : text_(text),
        limits_(limits),
        run_(run),
        scanner_(text, 0, true),
        document_(std::make_unique<OffDocument>(text)) {}

  Result<std::unique_ptr<Document>> read() {
    if (auto ok = check_line_lengths(text_, 0, limits_); !ok) return ok.error();
    if (auto ok = read_keyword(); !ok) return ok.error();
    if (auto ok = read_counts(); !ok) return ok.error();
    if (auto ok = read_vertices(); !ok) return ok.error();
    if (auto ok = read_faces(); !ok) return ok.error();
    if (auto ok = run_.check(); !ok) return ok.error();
    document_->has_comments_ = text_.find('#') != std::string_view::npos;
    return std::unique_ptr<Document>(std::move(document_));
  }

 private:
  /// [ST][C][N][4][n]OFF, in the order of Geomview's manual.
  Result<> read_keyword() {
    scanner_.find_word();
    const TextScanner before = scanner_;
    std::string_view rest = scanner_.word();
    const auto takes = [&](std::string_view prefix) {
      const bool there = rest.starts_with(prefix);
      if (there) rest.remove_prefix(prefix.size());
      return there;
    };
    document_->has_textures_ = takes("ST");
    document_->has_colors_ = takes("C");
    has_normals_ = takes("N");
    const bool fourth = takes("4"), any_number = takes("n");
    if (rest != "OFF") {
      return before.fail(Cause::MalformedMesh,
                         "an OFF file begins with OFF, COFF, NOFF or the like instead of " + before.quoted());
    }
    if (fourth || any_number) {
      return before.fail(Cause::UnsupportedFormat,
                         "the vertices of " + before.quoted() + " do not have three coordinates");
    }
    TextScanner ahead = scanner_;
    if (ahead.find_word_of_line() && ahead.word() == "BINARY")
      return scanner_.fail(Cause::UnsupportedFormat, "the file is a binary OFF; only text can be read");
    return {};
  }

  Result<> read_counts() {
    if (auto ok = read_count("vertices", limits_.max_vertices, "max-vertices", vertices_); !ok) return ok;
    if (auto ok = read_count("faces", limits_.max_triangles, "max-triangles", faces_); !ok) return ok;
    std::int64_t edges = 0;  // which nobody counts
    if (scanner_.find_word_of_line()) scanner_.integer(edges);
    scanner_.skip_line();
    if (vertices_ == 0) return Error{Cause::EmptyMesh, "the OFF file has no vertex"};
    if (faces_ == 0) return Error{Cause::EmptyMesh, "the OFF file has no face"};
    // Counts that the rest of the file cannot hold allocate nothing.
    const std::uint64_t rest = text_.size() - scanner_.offset() + 1;
    if (rest / kLeastVertexBytes < vertices_ ||
        (rest - vertices_ * kLeastVertexBytes) / kLeastFaceBytes < faces_) {
      return scanner_.fail(Cause::MalformedMesh, "the file is too short for " + std::to_string(vertices_) +
                                                     " vertices and " + std::to_string(faces_) + " faces");
    }
    return {};
  }

  Result<> read_count(const std::string& what, std::uint64_t limit, const std::string& name,
                      std::uint64_t& count) {
    scanner_.find_word();
    const TextScanner before = scanner_;
    std::int64_t value = 0;
    if (!scanner_.integer(value) || value < 0) {
      return before.fail(Cause::MalformedMesh,
                         "the count of " + what + " is no whole number but " + before.quoted());
    }
    count = static_cast<std::uint64_t>(value);
    if (count <= limit) return {};
    return before.fail(Cause::TooLarge, "the mesh has " + std::to_string(count) + ' ' + what +
                                            "; the limit is " + std::to_string(limit) + " (" + name + ')');
  }

  Result<> read_vertices() {
    document_->positions_.resize(vertices_);
    document_->vertex_begins_.resize(vertices_);
    if (has_normals_) document_->normals_.resize(vertices_);
    for (std::uint64_t v = 0; v < vertices_; ++v) {
      if (v % kBlockSize == 0 && run_.stopped()) return run_.stop_error();
      Vec3d& position = document_->positions_[v];
      const auto name = [&] { return "vertex " + std::to_string(v); };
      if (!scanner_.find_word()) return scanner_.fail(Cause::MalformedMesh, "the file ends before " + name());
      document_->vertex_begins_[v] = scanner_.offset();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!scanner_.coordinate(position[axis])) return scanner_.coordinate_error(name(), axis);
      }
      for (std::size_t axis = 0; axis < 3 && has_normals_; ++axis) {
        double value = 0;
        if (!scanner_.find_word() || !scanner_.number(value)) {
          return scanner_.fail(Cause::MalformedMesh,
                               name() + ": its normal is not a number but " + scanner_.quoted());
        }
        const auto narrow = static_cast<float>(value);
        document_->normals_[v][axis] = std::isfinite(narrow) ? narrow : 0.0f;
      }
      scanner_.skip_line();
    }
    return {};
  }

  Result<> read_faces() {
    document_->triangles_.reserve(faces_);
    document_->face_begins_.resize(faces_);
    std::vector<Index> corners;
    for (std::uint64_t f = 0; f < faces_; ++f) {
      if (f % kBlockSize == 0 && run_.stopped()) return run_.stop_error();
      if (auto ok = read_face(f, corners); !ok) return ok;
      document_->has_face_colors_ |= scanner_.find_word_of_line();
      scanner_.skip_line();
      if (document_->triangles_.size() + corners.size() - 2 > limits_.max_triangles) {
        return scanner_.fail(
            Cause::TooLarge,
            "the mesh has more than " + std::to_string(limits_.max_triangles) + " triangles (max-triangles)");
      }
      add_fan(corners, static_cast<Index>(f), document_->triangles_, document_->face_of_triangle_);
    }
    return {};
  }

  Result<> read_face(std::uint64_t face, std::vector<Index>& corners) {
    const auto name = [&] { return "face " + std::to_string(face); };
    if (!scanner_.find_word()) return scanner_.fail(Cause::MalformedMesh, "the file ends before " + name());
    document_->face_begins_[face] = scanner_.offset();
    const TextScanner before = scanner_;
    std::int64_t count = 0;
    if (!scanner_.integer(count))
      return before.fail(Cause::MalformedMesh, name() + ": its count of corners is " + before.quoted());
    if (count < 3) {
      return before.fail(Cause::MalformedMesh,
                         name() + " has " + std::to_string(count) + " corners; it needs at least 3");
    }
    corners.clear();
    for (std::int64_t c = 0; c < count; ++c) {
      if (!scanner_.find_word()) return scanner_.fail(Cause::MalformedMesh, "the file ends in " + name());
      const TextScanner here = scanner_;
      std::int64_t vertex = 0;
      if (!scanner_.integer(vertex))
        return here.fail(Cause::MalformedMesh,
                         name() + ": a vertex index is not a number but " + here.quoted());
      if (vertex < 0 || static_cast<std::uint64_t>(vertex) >= vertices_) {
        return here.fail(Cause::IndexOutOfRange, name() + " uses vertex " + std::to_string(vertex) + " of " +
                                                     std::to_string(vertices_));
      }
      corners.push_back(static_cast<Index>(vertex));
    }
    return {};
  }

  std::string_view text_;
  const Limits& limits_;
  const RunControl& run_;
  TextScanner scanner_;
  std::unique_ptr<OffDocument> document_;
  bool has_normals_ = false;
  std::uint64_t vertices_ = 0, faces_ = 0;
};

Result<std::unique_ptr<Document>> decode_off(std::string_view bytes, const Limits& limits,
                                             const RunControl& run) {
  return OffReader(bytes, limits, run).read();
}

}  // namespace burnish
