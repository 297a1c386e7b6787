// Groups of an OBJ: a pass of its own over the text when a caller names one, so that nobody else pays for
// them.
#include <algorithm>
#include <utility>

#include "core/io/obj_document.h"
#include "core/io/pins.h"

namespace burnish {
namespace {

constexpr std::size_t kBytesBetweenChecks = 64 << 10;

bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// Goes from statement to statement exactly as the parser did, which has accepted the text: the faces that
/// both count must be the same.
class GroupReader {
 public:
  GroupReader(std::string_view text, std::string_view wanted)
      : at_(text.data()), end_(at_ + text.size()), wanted_(wanted) {}

  /// Calls face(inside) for every face in order. False when stopped.
  template <class Face>
  bool read(const RunControl& run, Face&& face) {
    for (const char* next_check = at_; at_ != end_; skip_line()) {
      if (at_ >= next_check) {
        if (run.stopped()) return false;
        next_check = at_ + std::min(kBytesBetweenChecks, static_cast<std::size_t>(end_ - at_));
      }
      skip_blanks();
      const std::string_view keyword = word([](char) { return false; });
      if (keyword == "g" && at_ > names_end_) {
        read_names();
      } else if (keyword == "f") {
        if (!grouped_) begin_group({});
        face(inside_);
      } else if (keyword == "vn") {
        skip_normal();
      }
    }
    return true;
  }

  bool found() const { return found_; }
  const KnownNames& names() const { return names_; }

 private:
  /// Leaves the cursor where it was: what follows a hidden line end is a name here, but may be a face to the
  /// parser.
  void read_names() {
    const char* const begin = at_;
    std::vector<std::string_view> names;
    for (;;) {
      skip_blanks();
      const std::string_view name = word([this](char) { return hidden_line_end() > 0; });
      if (name.empty() || name.front() == '#') break;
      names.push_back(name);
    }
    begin_group(names);
    names_end_ = std::exchange(at_, begin);
  }

  void begin_group(std::span<const std::string_view> names) {
    static constexpr std::string_view kUnnamed[] = {"default"};
    if (names.empty()) names = kUnnamed;
    inside_ = std::ranges::find(names, wanted_) != names.end();
    found_ |= inside_;
    for (const std::string_view name : names) names_.add(name);
    grouped_ = true;
  }

  /// Up to a blank, a line end, or where `ends` says so.
  template <class Ends>
  std::string_view word(Ends&& ends) {
    const char* const begin = at_;
    while (at_ != end_ && !is_blank(*at_) && !is_line_end(*at_) && !ends(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  /// Three words, wherever they stand: unlike the numbers of other statements behind a backslash, they may
  /// look like a statement.
  void skip_normal() {
    for (int axis = 0; axis < 3; ++axis) {
      skip_blanks();
      word([this](char c) { return c == '#' || hidden_line_end() > 0; });
    }
  }

  void skip_blanks() {
    while (at_ != end_) {
      const std::size_t length = is_blank(*at_) ? 1 : hidden_line_end();
      if (length == 0) return;
      at_ += length;
    }
  }

  /// Length of a line end behind a backslash; 0 when there is none here.
  std::size_t hidden_line_end() const {
    if (*at_ != '\\' || at_ + 1 == end_ || !is_line_end(at_[1])) return 0;
    return at_[1] == '\r' && at_ + 2 != end_ && at_[2] == '\n' ? 3 : 2;
  }

  void skip_line() {
    while (at_ != end_ && !is_line_end(*at_)) ++at_;
    if (at_ != end_) ++at_;
  }

  const char* at_;
  const char* const end_;
  const char* names_end_ = at_;  // of the last g statement
  const std::string_view wanted_;
  bool grouped_ = false;  // a group has begun
  bool inside_ = false;   // in the one that is wanted
  bool found_ = false;
  KnownNames names_;
};

}  // namespace

Result<std::vector<Index>> ObjDocument::group_vertices(std::string_view name, const RunControl& run) const {
  std::vector<std::uint8_t> inside(positions_.size());
  Index face = 0;
  std::size_t next = 0;
  GroupReader reader(text_, name);
  const bool done = reader.read(run, [&](bool wanted) {
    const auto is_of_face = [&](std::size_t t) {
      return face_of_triangle_.empty() ? t == face : face_of_triangle_[t] == face;
    };
    for (; next < triangles_.size() && is_of_face(next); ++next) {
      if (!wanted) continue;
      for (const Index v : triangles_[next]) inside[v] = 1;
    }
    ++face;
  });
  if (!done) return run.stop_error();
  if (!reader.found()) return reader.names().missing("group", name);
  std::vector<Index> vertices;
  for (Index v = 0; v < inside.size(); ++v) {
    if (inside[v] != 0) vertices.push_back(v);
  }
  return vertices;
}

}  // namespace burnish
