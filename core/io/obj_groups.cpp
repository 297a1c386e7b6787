// Groups of an OBJ: a pass of its own over the text when a caller names one, so that nobody else pays for
// them.
#include <algorithm>

#include "core/io/obj_document.h"
#include "core/io/obj_statements.h"
#include "core/io/pins.h"

namespace burnish {
namespace {

constexpr std::size_t kBytesBetweenChecks = 64 << 10;

/// Tells of each face whether it is in the wanted group.
class GroupReader {
 public:
  GroupReader(std::string_view text, std::string_view wanted)
      : end_(text.data() + text.size()), statements_(text), names_end_(text.data()), wanted_(wanted) {}

  /// Calls face(inside) for every face in order. False when stopped.
  template <class Face>
  bool read(const RunControl& run, Face&& face) {
    for (const char* next_check = statements_.at(); !statements_.at_end(); statements_.skip_line()) {
      if (statements_.at() >= next_check) {
        if (run.stopped()) return false;
        const auto rest = static_cast<std::size_t>(end_ - statements_.at());
        next_check = statements_.at() + std::min(kBytesBetweenChecks, rest);
      }
      const std::string_view keyword = statements_.keyword();
      if (keyword == "g" && statements_.at() > names_end_) {
        read_names();
      } else if (keyword == "f") {
        if (!grouped_) begin_group({});
        face(inside_);
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
    const char* const begin = statements_.at();
    std::vector<std::string_view> names;
    for (;;) {
      const std::string_view name = statements_.name();
      if (name.empty() || name.front() == '#') break;
      names.push_back(name);
    }
    begin_group(names);
    names_end_ = statements_.at();
    statements_.go_back_to(begin);
  }

  void begin_group(std::span<const std::string_view> names) {
    static constexpr std::string_view kUnnamed[] = {"default"};
    if (names.empty()) names = kUnnamed;
    inside_ = std::ranges::find(names, wanted_) != names.end();
    found_ |= inside_;
    for (const std::string_view name : names) names_.add(name);
    grouped_ = true;
  }

  const char* const end_;
  ObjStatements statements_;
  const char* names_end_;  // of the last g statement
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
