#include "core/io/pins.h"

#include <algorithm>

#include "core/run/parallel.h"

namespace burnish {
namespace {

constexpr std::size_t kMostNames = 8;

Error not_of_format(Format format, const std::string& kind) {
  return {Cause::BadOption, std::string(traits_of(format).title) + " has no " + kind + "s to pin by",
          "pinned." + kind};
}

Result<> pin(std::span<const Index> vertices, Surface& surface, const RunControl& run) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (i % kBlockSize == 0 && run.stopped()) return run.stop_error();
    surface.pinned[surface.weld[vertices[i]]] = 1;
  }
  return {};
}

}  // namespace

Result<std::vector<Index>> Document::group_vertices(std::string_view, const RunControl&) const {
  return not_of_format(format_, "group");
}

Result<std::vector<Index>> Document::attribute_vertices(std::string_view, const RunControl&) const {
  return not_of_format(format_, "attribute");
}

Result<std::uint32_t> pin_vertices(const Document& document, const PinOptions& options, Surface& surface,
                                   const RunControl& run) {
  if (options.vertices.empty() && options.group.empty() && options.attribute.empty()) return 0U;
  const std::size_t count = document.positions().size();
  for (std::size_t i = 0; i < options.vertices.size(); ++i) {
    if (options.vertices[i] < count) continue;
    const std::string field = "pinned.vertices[" + std::to_string(i) + "]";
    return Error{Cause::BadOption,
                 field + " is " + std::to_string(options.vertices[i]) + " but the mesh has " +
                     std::to_string(count) + " vertices, counted from 0",
                 field};
  }
  surface.pinned.assign(surface.mesh.positions.size(), 0);
  if (auto pinned = pin(options.vertices, surface, run); !pinned) return pinned.error();
  if (!options.group.empty()) {
    const auto group = document.group_vertices(options.group, run);
    if (!group) return group.error();
    if (auto pinned = pin(*group, surface, run); !pinned) return pinned.error();
  }
  if (!options.attribute.empty()) {
    const auto chosen = document.attribute_vertices(options.attribute, run);
    if (!chosen) return chosen.error();
    if (auto pinned = pin(*chosen, surface, run); !pinned) return pinned.error();
  }
  return static_cast<std::uint32_t>(
      std::ranges::count_if(surface.weld, [&](Index v) { return surface.pinned[v] != 0; }));
}

void KnownNames::add(std::string_view name) {
  const std::string text = quote(name);
  if (more_ || std::ranges::find(names_, text) != names_.end()) return;
  if (names_.size() < kMostNames) {
    names_.push_back(text);
  } else {
    more_ = true;
  }
}

Error KnownNames::missing(std::string_view kind, std::string_view wanted) const {
  std::string list;
  for (const std::string& name : names_) list += (list.empty() ? "" : ", ") + name;
  return {Cause::BadOption,
          "the mesh has no " + std::string(kind) + ' ' + quote(wanted) + "; it has " + list +
              (more_ ? " and more" : ""),
          "pinned." + std::string(kind)};
}

std::string quote(std::string_view text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 64)) result += c >= 32 && c < 127 ? c : '?';
  return result + '"';
}

}  // namespace burnish
