// A whole picture: meshes side by side with their names, and the legend of a heat map.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "client/render/shading.h"
#include "core/run/run_control.h"

namespace burnish::render {

struct Panel {
  Model model;
  std::string label;  ///< below it; empty: none
  View view = {};
};

/// What the colours of Model::heat stand for.
struct Legend {
  double most = 1;    ///< value of the darkest colour; the palest is 0
  bool open = false;  ///< there are larger values, which are as dark
  std::string title;  ///< "distance to the reference in mm"
};

enum class Fit : std::uint8_t {
  Row,   ///< meshes of a row are seen from one place, so that they can be compared
  Each,  ///< each fills its own panel
};

struct Sheet {
  unsigned width = 1200, height = 600;  ///< pixels, kLeastSide to kMostSide
  unsigned columns = 0;                 ///< 0: one row
  Fit fit = Fit::Row;
  double margin = 0.04;    ///< share of a panel's smaller side that stays free
  unsigned text_size = 0;  ///< pixels; 0: as suits the panels
  std::optional<Legend> legend = {};
  Look look = {};
};

inline constexpr unsigned kLeastSide = 16, kMostSide = 16384;

/// Errors: BadOption when a panel has no room or there is no panel; those of draw().
Result<Picture> draw_sheet(std::span<const Panel> panels, const Sheet& sheet, const RunControl& run);

}  // namespace burnish::render
