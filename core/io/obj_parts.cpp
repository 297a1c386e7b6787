// Several threads read one OBJ file.
#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>

#include "core/io/obj_parser.h"
#include "core/run/parallel.h"

namespace burnish {

bool ObjParser::within_limits() const {
  return document_->positions_.size() <= limits_.max_vertices &&
         document_->triangles_.size() <= limits_.max_triangles;
}

void ObjParser::append(std::span<ObjParser> others, const RunControl& run) {
  struct Part {
    ObjDocument* document;
    std::size_t triangles;
    Index first_face;
  };
  std::vector<Part> parts{{document_.get(), document_->triangles_.size(), 0}};
  for (ObjParser& other : others) {
    parts.push_back({other.document_.get(), other.document_->triangles_.size(), faces_});
    farthest_vertex_.see(other.farthest_vertex_, faces_);
    farthest_texture_.see(other.farthest_texture_, faces_);
    farthest_normal_.see(other.farthest_normal_, faces_);
    faces_ += other.faces_;
    document_->has_more_ |= other.document_->has_more_;
  }
  const auto add_up = [&](auto member) {
    auto& items = document_.get()->*member;
    std::size_t count = 0;
    for (const Part& part : parts) count += (part.document->*member).size();
    items.reserve(count);
    for (const Part& part : std::span(parts).subspan(1)) {
      auto& more = part.document->*member;
      for (std::size_t begin = 0; begin < more.size() && !run.stopped(); begin += kBlockSize) {
        const auto block = std::span(more).subspan(begin, std::min(kBlockSize, more.size() - begin));
        items.insert(items.end(), block.begin(), block.end());
      }
      more = {};
    }
  };
  // Of arrays that are empty in the parts that have nothing to say.
  const auto add_up_rows = [&](auto member, auto&& row_of) {
    const auto speaks = [&](const Part& part) { return !(part.document->*member).empty(); };
    if (std::ranges::none_of(parts, speaks)) return;
    std::decay_t<decltype(document_.get()->*member)> rows;
    for (const Part& part : parts) {
      for (std::size_t t = 0; t < part.triangles; ++t) {
        if (t % kBlockSize == 0 && run.stopped()) return;
        rows.push_back(row_of(part, speaks(part) ? &(part.document->*member)[t] : nullptr, t));
      }
    }
    document_.get()->*member = std::move(rows);
  };
  const auto corners = [](const Part&, const Triangle* row, std::size_t) {
    return row != nullptr ? *row : Triangle{kNone, kNone, kNone};
  };
  const auto face = [](const Part& part, const Index* row, std::size_t t) {
    return part.first_face + (row != nullptr ? *row : static_cast<Index>(t));
  };
  const std::function<void()> arrays[] = {
      [&] { add_up(&ObjDocument::positions_); },
      [&] { add_up(&ObjDocument::triangles_); },
      [&] { add_up(&ObjDocument::vertex_text_); },
      [&] { add_up(&ObjDocument::normal_text_); },
      [&] { add_up(&ObjDocument::texture_text_); },
      [&] { add_up_rows(&ObjDocument::corner_normals_, corners); },
      [&] { add_up_rows(&ObjDocument::corner_textures_, corners); },
      [&] { add_up_rows(&ObjDocument::face_of_triangle_, face); },
  };
  parallel_tasks(std::size(arrays), run, [&](std::size_t i) { arrays[i](); });
}

namespace {

/// The first end of a line from `from` on that no backslash hides.
std::uint64_t end_of_lines(std::string_view text, std::uint64_t from) {
  for (std::size_t at = text.find('\n', from); at != std::string_view::npos; at = text.find('\n', at + 1)) {
    const std::size_t end = at > 0 && text[at - 1] == '\r' ? at - 1 : at;
    if (end == 0 || text[end - 1] != '\\') return at + 1;
  }
  return text.size();
}

/// Reads stretches of lines at once. Nothing when one of them holds a mistake, or an index that counts
/// backwards, or when they are too much together: reading in order then finds what to say.
std::optional<ObjParser> read_in_parts(std::string_view text, std::uint64_t part_bytes, const Limits& limits,
                                       const RunControl& run) {
  std::vector<ObjParser> parts;
  for (std::uint64_t begin = 0; begin < text.size();) {
    const std::uint64_t end =
        end_of_lines(text, std::min<std::uint64_t>(begin + part_bytes, text.size()) - 1);
    parts.emplace_back(text, TextRange{begin, end - begin}, limits, run);
    begin = end;
  }
  std::atomic<bool> trouble = false;
  parallel_tasks(parts.size(), run, [&](std::size_t i) {
    if (!trouble && !parts[i].read()) trouble = true;
  });
  if (trouble || run.stopped()) return std::nullopt;
  ObjParser all = std::move(parts.front());
  all.append(std::span(parts).subspan(1), run);
  if (!all.within_limits()) return std::nullopt;
  return all;
}

}  // namespace

Result<std::unique_ptr<Document>> decode_obj(std::string_view bytes, const Limits& limits,
                                             const RunControl& run, std::uint64_t part_bytes) {
  if (thread_count(run) > 1 && bytes.size() > part_bytes) {
    auto parser = read_in_parts(bytes, part_bytes, limits, run);
    if (run.stopped()) return run.stop_error();
    if (parser) return parser->finish();
  }
  ObjParser parser(bytes, {0, bytes.size()}, limits, run);
  if (auto read = parser.read(); !read) return read.error();
  return parser.finish();
}

}  // namespace burnish
