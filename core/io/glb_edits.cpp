#include "core/io/glb_edits.h"

#include <fast_float/fast_float.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace burnish {
namespace {

/// Replacements of stretches of a text.
class TextPatches {
 public:
  explicit TextPatches(std::string_view text) : text_(text) {}

  std::string_view text() const { return text_; }
  void replace(TextRange range, std::string with) { patches_.emplace_back(range, std::move(with)); }

  void number(TextRange range, double value) {
    double now = 0;
    const char* const begin = text_.data() + range.begin;
    const auto [end, failure] = fast_float::from_chars(begin, begin + range.length, now);
    if (failure == std::errc() && end == begin + range.length && now == value) return;
    replace(range, json_number(value));
  }

  void member(TextRange object, std::string_view name, double value) {
    if (const auto range = json_member(text_, object, name)) number(*range, value);
  }

  std::string finish() && {
    std::ranges::sort(patches_, {}, [](const auto& patch) { return patch.first.begin; });
    std::string out;
    std::uint64_t at = 0;
    for (const auto& [range, with] : patches_) {
      out.append(text_.substr(at, range.begin - at)).append(with);
      at = range.begin + range.length;
    }
    return out.append(text_.substr(at));
  }

 private:
  std::string_view text_;
  std::vector<std::pair<TextRange, std::string>> patches_;
};

void edit_vector(TextPatches& patches, TextRange object, std::string_view name, const Vec3d& value) {
  const auto array = json_member(patches.text(), object, name);
  if (!array) return;
  const auto elements = json_elements(patches.text(), *array);
  for (std::size_t axis = 0; axis < std::min<std::size_t>(3, elements.size()); ++axis) {
    patches.number(elements[axis], value[axis]);
  }
}

void edit(TextPatches& patches, TextRange object, const GlbEdits::Accessor& accessor) {
  if (accessor.count) patches.member(object, "count", static_cast<double>(*accessor.count));
  if (accessor.low) edit_vector(patches, object, "min", *accessor.low);
  if (accessor.high) edit_vector(patches, object, "max", *accessor.high);
}

void edit(TextPatches& patches, TextRange object, const GlbEdits::View& view) {
  patches.member(object, "byteOffset", static_cast<double>(view.offset));
  patches.member(object, "byteLength", static_cast<double>(view.length));
}

void edit(TextPatches& patches, TextRange object, const GlbEdits::Buffer& buffer) {
  patches.member(object, "byteLength", static_cast<double>(buffer.length));
  if (!buffer.uri) return;
  if (const auto range = json_member(patches.text(), object, "uri"))
    patches.replace(*range, '"' + *buffer.uri + '"');
}

template <class Edit>
void edit_list(TextPatches& patches, std::string_view name, const std::map<Index, Edit>& edits) {
  if (edits.empty()) return;
  const auto list = json_member(patches.text(), json_root(patches.text()), name);
  if (!list) return;
  const auto elements = json_elements(patches.text(), *list);
  for (const auto& [number, change] : edits) {
    if (number < elements.size()) edit(patches, elements[number], change);
  }
}

}  // namespace

std::string json_number(double value) {
  // Shortest text would be "1e+05" for a count.
  if (std::abs(value) < 0x1p53 && std::floor(value) == value) {
    return std::to_string(static_cast<std::int64_t>(value));
  }
  char digits[32];
  return {digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr};
}

std::string GlbEdits::apply(std::string_view json) const {
  TextPatches patches(json);
  edit_list(patches, "accessors", accessors);
  edit_list(patches, "bufferViews", views);
  edit_list(patches, "buffers", buffers);
  return std::move(patches).finish();
}

}  // namespace burnish
