// For formats whose vertices have one value of each attribute: copies vertices at seams.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// A file vertex with the attribute rows that a corner gives it.
struct SeamPoint {
  Index vertex = 0, normal = kNone, texture = kNone;
  friend bool operator==(const SeamPoint&, const SeamPoint&) = default;
};

/// Points 0 .. n-1 are the file's vertices, each with the attributes of the first corner that uses it; a
/// corner with other attributes (at a seam) gets a copy of its vertex after them, in the order of first use.
struct SeamPoints {
  std::vector<SeamPoint> points;
  std::vector<Triangle> triangles;
};

/// Errors: Cancelled, DeadlineExceeded.
Result<SeamPoints> split_at_seams(std::size_t vertices, std::span<const Triangle> triangles,
                                  const SharedAttributes& attributes, const RunControl& run);

}  // namespace burnish
