// The order of a mesh in memory. Scanners and subdivision leave neighbours far apart; every pass over the
// mesh then waits for memory (docs/decisions/0009-order-of-work.md).
#pragma once

#include "core/mesh/surface.h"

namespace burnish {

/// When its triangles jump about, sorts the vertices of a mesh along a space-filling curve and its triangles
/// by their first vertex, and corrects `weld` and `source_triangle`; files keep their order through these.
/// For use before the topology is built. False when stopped.
bool order_for_cache(Surface& surface, const RunControl& run);

}  // namespace burnish
