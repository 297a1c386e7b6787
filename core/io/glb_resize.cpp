// Buffers with bytes of another length in them.
#include <algorithm>

#include "core/io/glb_edits.h"

namespace burnish {
namespace {

/// A stretch that is replaced, with what fills it up so that what follows moves by whole words.
struct Piece {
  GlbReplacement with;
  std::uint64_t fill = 0;
  std::uint64_t begin() const { return with.place.begin; }
  std::uint64_t end() const { return with.place.begin + with.place.length; }
};

Error entangled(Index view, Index other) {
  return {Cause::CannotEncode, "bufferViews[" + std::to_string(other) + "] shares bytes with bufferViews[" +
                                   std::to_string(view) + "], whose compressed mesh gets another length"};
}

/// The pieces of one buffer, in its order.
class Resizer {
 public:
  Resizer(Index buffer, std::vector<Piece> pieces) : buffer_(buffer), pieces_(std::move(pieces)) {
    std::ranges::sort(pieces_, {}, [](const Piece& p) { return p.begin(); });
    for (Piece& piece : pieces_) {
      piece.fill = (piece.end() - piece.begin() - piece.with.bytes.size()) % 4;
      growth_.push_back(growth_.back() + piece.with.bytes.size() + piece.fill -
                        (piece.end() - piece.begin()));
    }
  }

  Index buffer() const { return buffer_; }

  Result<> separate() const {
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      if (pieces_[i].begin() < pieces_[i - 1].end()) {
        return entangled(pieces_[i - 1].with.view, pieces_[i].with.view);
      }
    }
    return {};
  }

  /// What becomes of a view of this buffer.
  Result<GlbEdits::View> moved(Index number, const GlbView& view) const {
    const auto behind =
        std::ranges::lower_bound(pieces_, view.begin, {}, [](const Piece& p) { return p.begin(); });
    const auto index = static_cast<std::size_t>(behind - pieces_.begin());
    const GlbEdits::View same{view.begin + growth_[index], view.length};
    if (behind != pieces_.end() && behind->with.view == number) {
      return GlbEdits::View{same.offset, behind->with.bytes.size()};
    }
    if (view.length == 0) return same;
    if (index > 0 && view.begin < pieces_[index - 1].end())
      return entangled(pieces_[index - 1].with.view, number);
    if (behind != pieces_.end() && behind->begin() < view.begin + view.length) {
      return entangled(behind->with.view, number);
    }
    return same;
  }

  std::string written(std::string_view bytes) const {
    std::string out;
    std::uint64_t at = 0;
    for (const Piece& piece : pieces_) {
      out.append(bytes.substr(at, piece.begin() - at)).append(piece.with.bytes).append(piece.fill, '\0');
      at = piece.end();
    }
    return out.append(bytes.substr(at));
  }

 private:
  Index buffer_;
  std::vector<Piece> pieces_;
  std::vector<std::uint64_t> growth_ = {0};  // before each piece, modulo 2^64
};

}  // namespace

Result<> replace_views(const GlbFile& file, std::vector<GlbReplacement> replacements, GlbBuffers& buffers,
                       GlbEdits& edits) {
  std::map<Index, std::vector<Piece>> by_buffer;
  for (GlbReplacement& each : replacements) by_buffer[each.place.buffer].push_back({std::move(each)});
  for (auto& [buffer, pieces] : by_buffer) {
    const Resizer resizer(buffer, std::move(pieces));
    if (auto ok = resizer.separate(); !ok) return ok;
    const JsonValue& views = *file.json().find("bufferViews");
    for (const JsonValue& json : views.items) {
      const auto number = static_cast<Index>(&json - views.items.data());
      const JsonValue* const of = json.find("buffer");
      if (of == nullptr || of->number != buffer) continue;
      const std::string place = "bufferViews[" + std::to_string(number) + "]";
      const auto view =
          file.view({.kind = JsonValue::Kind::Number, .number = static_cast<double>(number)}, place);
      if (!view) return Error{Cause::CannotEncode, view.error().message};
      const auto moved = resizer.moved(number, *view);
      if (!moved) return moved.error();
      edits.views[number] = *moved;
    }
    std::string& bytes = buffers.change(buffer);
    bytes = resizer.written(bytes);
    edits.buffers[buffer].length = bytes.size();
  }
  return {};
}

}  // namespace burnish
