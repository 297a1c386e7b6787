// OFF (Geomview's Object File Format), text. Reads positions and polygons, and the normals of NOFF; carries
// colours, texture coordinates (ST), comments and layout through untouched. A vertex and a face each end
// their line; what stands there beside their numbers is theirs.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// Errors: UnsupportedFormat (binary, 4OFF, nOFF), MalformedMesh, IndexOutOfRange, NonFinitePosition,
/// EmptyMesh, TooLarge, Cancelled, DeadlineExceeded; each names the line. `bytes` must outlive the Document.
Result<std::unique_ptr<Document>> decode_off(std::string_view bytes, const Limits& limits,
                                             const RunControl& run);

/// Writes any mesh as a new OFF, or as COFF when it has colours: whole bytes as 0 to 255, others as they are.
/// Errors: Cancelled, DeadlineExceeded.
Result<Encoded> encode_as_off(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run);

}  // namespace burnish
