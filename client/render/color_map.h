// Colours of a heat map: pale where a value is small, dark where it is large.
#pragma once

#include <array>

#include "client/render/picture.h"

namespace burnish::render {

/// The colour of `share` of the range, clamped to [0, 1]: from a pale grey over amber and red to plum, in
/// steps that become darker throughout, so that it also reads in grey. Each channel is linear between the
/// five stops, at quarters.
Color heat_color(double share);

/// The end of a legend: the least 1, 2, 2.5 or 5 times a power of ten that is not below `value`; 0 for 0.
double round_up(double value);

}  // namespace burnish::render
