// The lines that nearly all files consist of, and the loop over all.
#include <algorithm>
#include <array>

#include "core/io/obj_parser.h"
#include "core/io/plain_number.h"

namespace burnish {
namespace {

constexpr std::uint64_t kBytesBetweenChecks = 64 << 10;

}  // namespace

ObjParser::ObjParser(std::string_view text, const TextRange& lines, const Limits& limits,
                     const RunControl& run)
    : text_(text),
      at_(text.data() + lines.begin),
      file_end_(at_ + lines.length),
      plain_end_(file_end_ - std::min<std::uint64_t>(lines.length, kPlainNumberReach)),
      knows_counts_(lines.begin == 0),
      limits_(limits),
      run_(run) {
  document_->text_ = text;
  // Of a usual file; pages that nobody writes to cost nothing.
  constexpr std::uint64_t kBytesPerVertex = 64;
  document_->positions_.reserve(lines.length / kBytesPerVertex);
  document_->vertex_text_.reserve(lines.length / kBytesPerVertex);
  document_->triangles_.reserve(lines.length / kBytesPerVertex * 2);
}

/// Goes to the next word of a plain line; false at the end of what a plain line may be.
// Inline: they are the loop below, taken apart.
inline bool ObjParser::plain_word(const char*& at) const {
  while (at < plain_end_ && is_blank(*at)) ++at;
  return at < plain_end_;
}

inline bool ObjParser::end_plain_line(const char* at) {
  while (at < plain_end_ && !is_line_end(*at)) ++at;
  if (at >= plain_end_ || static_cast<std::uint64_t>(at - at_) > limits_.max_line_bytes) return false;
  at_ = at + 1;
  return true;
}

inline bool ObjParser::read_plain_vertex() {
  Vec3d position;
  const char* at = at_ + 1;
  const char* begin = nullptr;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!plain_word(at)) return false;
    if (axis == 0) begin = at;
    if (!read_plain_decimal(at, position[axis]) || !(is_blank(*at) || is_line_end(*at))) return false;
  }
  if (document_->positions_.size() >= limits_.max_vertices || !end_plain_line(at)) return false;
  document_->positions_.push_back(position);
  document_->vertex_text_.push_back(range(begin, at));
  return true;
}

inline bool ObjParser::read_plain_corner(const char*& at, ObjCorner& corner) const {
  const auto index = [&](Index& zero_based) {
    if (!read_plain_integer(at, zero_based)) return false;
    return zero_based-- > 0;
  };
  if (!index(corner.vertex)) return false;
  if (*at == '/') {
    ++at;
    if (*at != '/' && !index(corner.texture)) return false;
    if (*at == '/' && (++at, !index(corner.normal))) return false;
  }
  return is_blank(*at) || is_line_end(*at);
}

inline bool ObjParser::read_plain_face() {
  std::array<ObjCorner, 4> corners;
  std::size_t count = 0;
  const char* at = at_ + 1;
  for (; plain_word(at) && !is_line_end(*at); ++count) {
    if (count == corners.size() || !read_plain_corner(at, corners[count])) return false;
  }
  if (count < 3 || document_->triangles_.size() + count - 2 > limits_.max_triangles) return false;
  const std::uint64_t line = offset(at_);
  if (!end_plain_line(at)) return false;
  std::int32_t vertex = -1, texture = -1, normal = -1;  // as kNone is, which thus is never far
  for (const ObjCorner& corner : std::span(corners).first(count)) {
    vertex = std::max(vertex, static_cast<std::int32_t>(corner.vertex));
    texture = std::max(texture, static_cast<std::int32_t>(corner.texture));
    normal = std::max(normal, static_cast<std::int32_t>(corner.normal));
  }
  farthest_vertex_.see(vertex, line, faces_);
  farthest_texture_.see(texture, line, faces_);
  farthest_normal_.see(normal, line, faces_);
  if (count == 3 && texture < 0 && normal < 0 && only_plain_triangles_) {
    document_->triangles_.push_back({corners[0].vertex, corners[1].vertex, corners[2].vertex});
  } else {
    add_fan(std::span(corners).first(count));
  }
  ++faces_;
  return true;
}

/// The lines that nearly all files consist of, "v 0.5 -1 2" and "f 1 2/2 3//3". False, and nothing is read,
/// for all others and for those with mistakes: the general reader below takes them.
inline bool ObjParser::read_plain_line() {
  if (!is_blank(at_[1])) return false;
  return *at_ == 'v' ? read_plain_vertex() : *at_ == 'f' && read_plain_face();
}

Result<> ObjParser::read() {
  for (const char* next_check = at_; at_ != file_end_;) {
    if (at_ >= next_check) {
      if (run_.stopped()) return run_.stop_error();
      next_check = at_ + std::min(kBytesBetweenChecks, rest());
    }
    if (at_ < plain_end_ && read_plain_line()) continue;
    const char* const begin = at_;
    // An endless line ends at its limit; one that fits still shows its end there.
    end_ = begin + (limits_.max_line_bytes < rest() ? limits_.max_line_bytes + 1 : rest());
    const auto line = parse_line();
    const bool endless = !skip_line() && static_cast<std::uint64_t>(at_ - begin) > limits_.max_line_bytes;
    if (endless) return too_long(begin);
    if (!line) return line.error();
  }
  return {};
}

}  // namespace burnish
