#include "client/render/sheet.h"

#include <algorithm>
#include <cstdio>

#include "client/render/color_map.h"
#include "client/render/ray_caster.h"
#include "client/render/text.h"

namespace burnish::render {
namespace {

/// Where everything goes, in pixels.
struct Layout {
  unsigned columns, rows, cell_width, cell_height;
  unsigned label_height;   ///< of each cell, at its foot
  unsigned legend_height;  ///< of the picture, at its foot
};

bool has_labels(std::span<const Panel> panels) {
  return std::ranges::any_of(panels, [](const Panel& panel) { return !panel.label.empty(); });
}

Result<Layout> layout_of(std::span<const Panel> panels, const Sheet& sheet, const Text& text) {
  Layout layout{};
  const auto count = static_cast<unsigned>(panels.size());
  if (count == 0) return Error{Cause::BadOption, "a picture needs a mesh"};
  const unsigned line = text.ascent() + text.descent();
  layout.columns = std::min(sheet.columns == 0 ? count : sheet.columns, count);
  layout.rows = (count + layout.columns - 1) / layout.columns;
  layout.legend_height = sheet.legend ? 3 * line + line / 2 : 0;
  layout.label_height = has_labels(panels) ? line + line / 2 : 0;
  const unsigned rest = sheet.height > layout.legend_height ? sheet.height - layout.legend_height : 0;
  layout.cell_width = sheet.width / layout.columns;
  layout.cell_height = rest / layout.rows;
  constexpr unsigned kLeastCell = 8;
  if (layout.cell_width >= kLeastCell && layout.cell_height >= layout.label_height + kLeastCell)
    return layout;
  return Error{Cause::BadOption, "a picture of " + std::to_string(sheet.width) + " by " +
                                     std::to_string(sheet.height) + " pixels has no room for " +
                                     std::to_string(count) + " meshes"};
}

/// What a panel shows: the row's meshes together, or its own.
Extent extent_of(std::span<const Panel> panels, std::size_t panel, const Layout& layout, Fit fit) {
  const std::size_t begin = fit == Fit::Each ? panel : panel / layout.columns * layout.columns;
  const std::size_t end = fit == Fit::Each ? panel + 1 : std::min(begin + layout.columns, panels.size());
  const Axes axes = axes_of(panels[panel].view);
  Extent extent;
  for (std::size_t i = begin; i < end; ++i) extent.add(axes, panels[i].model.positions);
  return extent;
}

/// Readable on the background.
Color ink(const Color& background) {
  const Light light = to_light(background);
  return 0.2126F * light.red + 0.7152F * light.green + 0.0722F * light.blue > 0.18F ? Color{58, 62, 68}
                                                                                    : Color{226, 228, 231};
}

std::string number(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", value);
  return buffer.data();
}

void draw_legend(Picture& picture, const Legend& legend, const Layout& layout, const Text& text,
                 const Color& background) {
  const unsigned line = text.ascent() + text.descent(), width = picture.width * 2 / 5;
  const unsigned left = (picture.width - width) / 2, top = picture.height - layout.legend_height + line / 4;
  const unsigned thick = std::max(line / 2, 2U);
  for (unsigned x = 0; x < width; ++x) {
    const Color color = heat_color((x + 0.5) / width);
    for (unsigned y = 0; y < thick; ++y) picture.at(left + x, top + y) = color;
  }
  const Color dark = ink(background);
  const int base = static_cast<int>(top + thick + text.ascent() + line / 8);
  for (const double share : {0.0, 0.5, 1.0}) {
    const std::string tick = number(share * legend.most) + (legend.open && share == 1 ? " or more" : "");
    text.draw_centred(picture, static_cast<int>(left + share * width), base, tick, dark);
  }
  text.draw_centred(picture, static_cast<int>(picture.width / 2), base + static_cast<int>(line), legend.title,
                    dark);
}

/// The longest beginning of the text that fits, marked where it was cut.
std::string fitting(std::string label, const Text& text, unsigned width) {
  if (text.width(label) <= width) return label;
  while (!label.empty() && text.width(label + "…") > width) {
    do label.pop_back();
    while (!label.empty() && (static_cast<unsigned char>(label.back()) & 0xC0U) == 0x80);
  }
  return label.empty() ? label : label + "…";
}

unsigned text_size(const Sheet& sheet, std::size_t panels) {
  if (sheet.text_size > 0) return sheet.text_size;
  const auto columns =
      static_cast<unsigned>(sheet.columns == 0 ? panels : std::min<std::size_t>(sheet.columns, panels));
  return std::clamp(sheet.width / std::max(columns, 1U) / 22, 11U, 28U);
}

}  // namespace

Result<Picture> draw_sheet(std::span<const Panel> panels, const Sheet& sheet, const RunControl& run) {
  const auto text = Text::of_size(text_size(sheet, panels.size()));
  if (!text) return text.error();
  const auto layout = layout_of(panels, sheet, *text);
  if (!layout) return layout.error();
  Picture picture(sheet.width, sheet.height, sheet.look.background);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const auto column = static_cast<unsigned>(i) % layout->columns,
               row = static_cast<unsigned>(i) / layout->columns;
    const unsigned left = column * layout->cell_width, top = row * layout->cell_height;
    const unsigned height = layout->cell_height - layout->label_height;
    const Camera camera = look_at(panels[i].view, extent_of(panels, i, *layout, sheet.fit),
                                  layout->cell_width, height, sheet.margin);
    if (auto drawn = draw(picture, left, top, camera, panels[i].model, sheet.look, run); !drawn)
      return drawn.error();
    text->draw_centred(picture, static_cast<int>(left + layout->cell_width / 2),
                       static_cast<int>(top + height + text->ascent()),
                       fitting(panels[i].label, *text, layout->cell_width), ink(sheet.look.background));
    run.report(static_cast<double>(i + 1) / static_cast<double>(panels.size()));
  }
  if (sheet.legend) draw_legend(picture, *sheet.legend, *layout, *text, sheet.look.background);
  return picture;
}

}  // namespace burnish::render
