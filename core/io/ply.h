// PLY (Turk 1994): text, and binary of both byte orders. Reads the positions of the element "vertex" and the
// polygons of "face" or the strips of "tristrips"; carries every other property, element and comment through
// untouched.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// Positions must be float or double. Errors: UnsupportedFormat, MalformedMesh, IndexOutOfRange,
/// NonFinitePosition, EmptyMesh, NotATriangleMesh (points only), TooLarge, Cancelled, DeadlineExceeded; each
/// names the line or the byte. `bytes` must outlive the Document.
Result<std::unique_ptr<Document>> decode_ply(std::string_view bytes, const Limits& limits,
                                             const RunControl& run);

/// Writes any mesh as a new binary PLY, least byte first: x y z as float, or as double where the mesh is far
/// from its origin; then nx ny nz, s t, and red green blue as bytes, or as floats when they are no whole
/// bytes. A corner with other attributes than its vertex (at a seam) gets a copy, as in Draco. Errors:
/// Cancelled, DeadlineExceeded.
Result<Encoded> encode_as_ply(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run);

}  // namespace burnish
