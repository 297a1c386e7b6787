// STL, text and binary. The file has three positions for each facet; equal ones are one vertex of the
// Document, in the order of their first use, so they move as one and other formats get a mesh that is
// connected.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// True when the bytes are as many as a binary STL that declares their count of facets has, or fewer than one
/// facet more.
bool has_binary_stl_size(std::string_view bytes);

/// True when the header is text, padded by NUL or not, and declares more facets than there are bytes for.
bool is_cut_binary_stl(std::string_view bytes);

/// Facets keep their order, their attribute bytes, the header, names and layout. A normal is recomputed where
/// its facet moved, unless it is 0 0 0. Errors: MalformedMesh, NonFinitePosition, EmptyMesh, TooLarge,
/// Cancelled, DeadlineExceeded; each names the line or the byte. `bytes` must outlive the Document.
Result<std::unique_ptr<Document>> decode_stl(std::string_view bytes, const Limits& limits,
                                             const RunControl& run);

/// Writes any mesh as a new binary STL, a facet for each triangle in order. Positions become floats. Errors:
/// Cancelled, DeadlineExceeded.
Result<Encoded> encode_as_stl(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const RunControl& run);

}  // namespace burnish
