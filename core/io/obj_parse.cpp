#include <fast_float/fast_float.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/io/obj_parser.h"

namespace burnish {
namespace {

std::string index_text(const char* begin, const char* stop) {
  return std::string(begin, std::min<std::size_t>(static_cast<std::size_t>(stop - begin), 24));
}

}  // namespace

Result<> ObjParser::parse_line() {
  skip_blanks();
  if (at_ == end_ || is_line_end(*at_) || *at_ == '#') return {};
  const char* const keyword = at_;
  while (at_ != end_ && !is_blank(*at_) && !is_line_end(*at_)) ++at_;
  const std::string_view word(keyword, static_cast<std::size_t>(at_ - keyword));
  if (word == "v") return parse_vertex();
  if (word == "f") return parse_face();
  if (word == "vn") return parse_normal();
  if (word == "vt") {
    const char* const begin = at_;
    while (at_ != end_ && !is_line_end(*at_)) ++at_;
    document_->texture_text_.push_back(range(begin, at_));
  } else {
    document_->has_more_ = true;
  }
  return {};
}

Result<> ObjParser::parse_vertex() {
  Vec3d position;
  const char* begin = nullptr;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    skip_blanks();
    if (axis == 0) begin = at_;
    const char* number = at_ != end_ && *at_ == '+' ? at_ + 1 : at_;
    const auto [stop, failure] = fast_float::from_chars(number, end_, position[axis]);
    if (failure != std::errc() || !at_token_end(stop)) {
      return fail(Cause::MalformedMesh, at_,
                  vertex_name() + ": coordinate " + "xyz"[axis] + " is not a number but " + token());
    }
    if (!(std::abs(position[axis]) <= kLargestCoordinate)) {
      return fail(Cause::NonFinitePosition, at_,
                  vertex_name() + ": coordinate " + "xyz"[axis] + " is " + token() +
                      (std::isfinite(position[axis]) ? ", beyond 1e60" : ", not a finite number"));
    }
    at_ = stop;
  }
  if (document_->positions_.size() >= limits_.max_vertices) {
    return fail(
        Cause::TooLarge, begin,
        "the mesh has more than " + std::to_string(limits_.max_vertices) + " vertices (max-vertices)");
  }
  document_->positions_.push_back(position);
  document_->vertex_text_.push_back(range(begin, at_));
  return {};
}

/// Where the three numbers stand; what they are matters only when the mesh is converted.
Result<> ObjParser::parse_normal() {
  skip_blanks();
  const char* const begin = at_;
  const char* stop = at_;
  for (int axis = 0; axis < 3; ++axis) {
    skip_blanks();
    while (at_ != end_ && !at_token_end(at_)) ++at_;
    stop = at_;
  }
  document_->normal_text_.push_back(range(begin, stop));
  return {};
}

Result<> ObjParser::parse_face() {
  corners_.clear();
  const char* const begin = at_;
  for (;;) {
    skip_blanks();
    if (at_ == end_ || is_line_end(*at_) || *at_ == '#') break;
    ObjCorner corner;
    if (auto result = parse_corner(corner); !result) return result;
    corners_.push_back(corner);
  }
  if (corners_.size() < 3) {
    return fail(Cause::MalformedMesh, begin,
                face_name() + " has " + std::to_string(corners_.size()) + " corners; it needs at least 3");
  }
  if (document_->triangles_.size() + corners_.size() - 2 > limits_.max_triangles) {
    return fail(
        Cause::TooLarge, begin,
        "the mesh has more than " + std::to_string(limits_.max_triangles) + " triangles (max-triangles)");
  }
  add_fan(corners_);
  ++faces_;
  return {};
}

/// v, v/vt, v//vn or v/vt/vn.
Result<> ObjParser::parse_corner(ObjCorner& corner) {
  if (auto r = parse_index("vertex", document_->positions_.size(), farthest_vertex_, corner.vertex); !r)
    return r;
  if (at_ == end_ || *at_ != '/') return end_of_corner();
  ++at_;
  if (at_ != end_ && *at_ != '/' && !at_token_end(at_)) {
    const std::size_t count = document_->texture_text_.size();
    if (auto r = parse_index("texture coordinate", count, farthest_texture_, corner.texture); !r) return r;
  }
  if (at_ == end_ || *at_ != '/') return end_of_corner();
  ++at_;
  if (at_ != end_ && !at_token_end(at_)) {
    const std::size_t count = document_->normal_text_.size();
    if (auto r = parse_index("normal", count, farthest_normal_, corner.normal); !r) return r;
  }
  return end_of_corner();
}

Result<> ObjParser::end_of_corner() const {
  if (at_token_end(at_)) return {};
  return fail(Cause::MalformedMesh, at_, face_name() + ": unexpected " + token() + " in a corner");
}

/// Positive: from 1, forwards too; negative: back from the latest.
Result<> ObjParser::parse_index(const char* kind, std::size_t count, FarthestReference& farthest,
                                Index& index) {
  std::int64_t value = 0;
  const char* const begin = at_;
  if (at_ != end_ && *at_ == '+') ++at_;
  const auto [stop, failure] = std::from_chars(at_, end_, value);
  if (failure == std::errc::invalid_argument) {
    return fail(Cause::MalformedMesh, begin,
                face_name() + ": a " + kind + " index is not a number but " + token());
  }
  if (value < 0 && !knows_counts_) return Error{Cause::Internal, "counts back from what came before"};
  const std::int64_t zero_based = value > 0 ? value - 1 : static_cast<std::int64_t>(count) + value;
  if (failure != std::errc() || value == 0 || zero_based < 0 || zero_based >= std::int64_t{kNone}) {
    at_ = begin;
    return fail(Cause::IndexOutOfRange, begin,
                face_name() + " uses " + kind + ' ' + index_text(begin, stop) +
                    (value == 0 ? "; OBJ counts from 1" : " of " + std::to_string(count)));
  }
  farthest.see(zero_based, offset(begin), faces_);
  index = static_cast<Index>(zero_based);
  at_ = stop;
  return {};
}

void ObjParser::add_fan(std::span<const ObjCorner> corners) {
  only_plain_triangles_ = false;
  const Index first = static_cast<Index>(document_->triangles_.size());
  for (std::size_t c = 2; c < corners.size(); ++c) {
    const ObjCorner &a = corners[0], &b = corners[c - 1], &d = corners[c];
    document_->triangles_.push_back({a.vertex, b.vertex, d.vertex});
    append_corners(document_->corner_textures_, {a.texture, b.texture, d.texture});
    append_corners(document_->corner_normals_, {a.normal, b.normal, d.normal});
  }
  std::vector<Index>& faces = document_->face_of_triangle_;
  if (faces.empty() && corners.size() == 3) return;
  for (Index t = static_cast<Index>(faces.size()); t < first; ++t) faces.push_back(t);
  faces.resize(document_->triangles_.size(), faces_);
}

/// The arrays stay empty until a face cites something.
void ObjParser::append_corners(std::vector<Triangle>& rows, const Triangle& corners) const {
  const bool cites = corners[0] != kNone || corners[1] != kNone || corners[2] != kNone;
  if (rows.empty() && !cites) return;
  rows.resize(document_->triangles_.size() - 1, {kNone, kNone, kNone});
  rows.push_back(corners);
}

Result<> ObjParser::check_references() const {
  const auto check = [&](const FarthestReference& farthest, const char* kind, std::size_t count) -> Result<> {
    if (farthest.index < static_cast<std::int64_t>(count)) return {};
    return Error{Cause::IndexOutOfRange, "face " + std::to_string(farthest.face + 1) + " uses " + kind + ' ' +
                                             std::to_string(farthest.index + 1) + " of " +
                                             std::to_string(count) + " (line " +
                                             std::to_string(line_at(text_, farthest.offset)) + ')'};
  };
  if (auto r = check(farthest_vertex_, "vertex", document_->positions_.size()); !r) return r;
  if (auto r = check(farthest_texture_, "texture coordinate", document_->texture_text_.size()); !r) return r;
  if (auto r = check(farthest_normal_, "normal", document_->normal_text_.size()); !r) return r;
  return {};
}

/// Blanks, and line ends that a backslash hides.
void ObjParser::skip_blanks() {
  while (at_ != end_) {
    if (is_blank(*at_)) {
      ++at_;
    } else if (const std::size_t hidden = continuation(at_); hidden > 0) {
      at_ += hidden;
    } else {
      return;
    }
  }
}

std::size_t ObjParser::continuation(const char* p) const {
  if (*p != '\\' || p + 1 == end_ || !is_line_end(p[1])) return 0;
  return p[1] == '\r' && p + 2 != end_ && p[2] == '\n' ? 3 : 2;
}

/// Goes past the end of the line; false when there is none before the cursor's end. The second half of CR
/// LF is an empty line to the next parse_line().
bool ObjParser::skip_line() {
  while (at_ != end_ && !is_line_end(*at_)) ++at_;
  if (at_ == end_) return false;
  ++at_;
  return true;
}

bool ObjParser::at_token_end(const char* p) const {
  return p == end_ || is_blank(*p) || is_line_end(*p) || *p == '#' || continuation(p) > 0;
}

/// The text at the cursor as a message quotes it.
std::string ObjParser::token() const {
  const char* stop = at_;
  while (!at_token_end(stop) && stop - at_ < 32) ++stop;
  if (stop == at_) return at_ == end_ ? "the end of the file" : "the end of the line";
  std::string quoted = "\"";
  for (const char* p = at_; p != stop; ++p) quoted += *p >= 32 && *p < 127 ? *p : '?';
  return quoted + '"';
}

Error ObjParser::too_long(const char* begin) const {
  return fail(Cause::TooLarge, begin,
              "a line has more than " + std::to_string(limits_.max_line_bytes) + " bytes (max-line-bytes)");
}

Error ObjParser::fail(Cause cause, const char* place, const std::string& message) const {
  return {cause, message + " (line " + std::to_string(line_at(text_, offset(place))) + ')'};
}

Result<std::unique_ptr<Document>> ObjParser::finish() {
  if (auto references = check_references(); !references) return references.error();
  if (document_->positions_.empty()) return Error{Cause::EmptyMesh, "the OBJ file has no vertex (v line)"};
  if (document_->triangles_.empty()) return Error{Cause::EmptyMesh, "the OBJ file has no face (f line)"};
  return std::unique_ptr<Document>(std::move(document_));
}

}  // namespace burnish
