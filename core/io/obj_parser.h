// Private to the OBJ codec: reads stretches of an OBJ file.
#pragma once

#include "core/io/obj_document.h"
#include "core/io/plain_number.h"

namespace burnish {

/// What a face says of one corner: 0-based, kNone where it says nothing.
struct ObjCorner {
  Index vertex = kNone, texture = kNone, normal = kNone;
};

/// The largest forward reference to one kind of element, to be checked when the counts are known.
struct FarthestReference {
  std::int64_t index = -1;
  std::uint64_t offset = 0;
  Index face = 0;

  void see(std::int64_t candidate, std::uint64_t place, Index by_face) {
    if (candidate > index) *this = {candidate, place, by_face};
  }
  /// What lines behind these cite, whose first face is number `first_face`.
  void see(const FarthestReference& other, Index first_face) {
    see(other.index, other.offset, first_face + other.face);
  }
};

/// Reads a stretch of whole lines once, line by line. Plain lines (obj_plain.cpp) are read by short functions
/// that leave everything else, mistakes above all, to the general ones (obj_parse.cpp).
class ObjParser {
 public:
  /// All that is given must outlive the parser.
  ObjParser(std::string_view text, const TextRange& lines, const Limits& limits, const RunControl& run);

  /// Errors: as decode_obj(). A stretch that does not begin the file knows no counts: an index that counts
  /// backwards is an error to it.
  Result<> read();

  /// Takes over what the stretches behind this one hold.
  void append(std::span<ObjParser> others, const RunControl& run);
  bool within_limits() const;

  /// The document, when its references and counts are right.
  Result<std::unique_ptr<Document>> finish();

 private:
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }

  bool read_plain_line();
  bool read_plain_vertex();
  bool read_plain_face();
  bool read_plain_corner(const char*& at, ObjCorner& corner) const;
  bool plain_word(const char*& at) const;
  bool end_plain_line(const char* at);

  Result<> parse_line();
  Result<> parse_vertex();
  Result<> parse_normal();
  Result<> parse_face();
  Result<> parse_corner(ObjCorner& corner);
  Result<> parse_index(const char* kind, std::size_t count, FarthestReference& farthest, Index& index);
  Result<> end_of_corner() const;

  void add_fan(std::span<const ObjCorner> corners);
  void append_corners(std::vector<Triangle>& rows, const Triangle& corners) const;
  Result<> check_references() const;

  void skip_blanks();
  bool skip_line();
  std::size_t continuation(const char* p) const;
  bool at_token_end(const char* p) const;

  std::string token() const;
  Error too_long(const char* begin) const;
  Error fail(Cause cause, const char* place, const std::string& message) const;
  std::string vertex_name() const { return "vertex " + std::to_string(document_->positions_.size() + 1); }
  std::string face_name() const { return "face " + std::to_string(faces_ + 1); }

  std::uint64_t rest() const { return static_cast<std::uint64_t>(file_end_ - at_); }
  std::uint64_t offset(const char* p) const { return static_cast<std::uint64_t>(p - text_.data()); }
  TextRange range(const char* begin, const char* stop) const {
    return {offset(begin), static_cast<std::uint64_t>(stop - begin)};
  }

  std::string_view text_;
  const char* at_;
  const char* const file_end_;
  const char* const plain_end_;  // before it a whole plain number can be read without looking for the end
  const char* end_ = nullptr;    // of what the line under way may read
  const bool knows_counts_;      // of elements before the stretch
  const Limits& limits_;
  const RunControl& run_;
  std::unique_ptr<ObjDocument> document_ = std::make_unique<ObjDocument>();
  std::vector<ObjCorner> corners_;
  Index faces_ = 0;
  bool only_plain_triangles_ = true;  // so far: nothing to say of faces beside their vertices
  FarthestReference farthest_vertex_, farthest_texture_, farthest_normal_;
};

}  // namespace burnish
