// Draco (google/draco bitstream 2.2 and older), triangle meshes only.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// Errors: NotATriangleMesh (point cloud), MalformedMesh, IndexOutOfRange, NonFinitePosition, EmptyMesh,
/// TooLarge, UnsupportedFormat, OutOfMemory, Cancelled, DeadlineExceeded. The library call itself cannot be
/// interrupted.
Result<std::unique_ptr<Document>> decode_draco(std::string_view bytes, const Limits& limits,
                                               const RunControl& run);

/// Writes any mesh as a new Draco file: positions, normals, texture coordinates and colours. Points 0 to n-1
/// are the n vertices in their order, each with the attributes of the first corner that uses it; a corner
/// with others (at a seam) gets a copy of its vertex after them, in the order of first use. Colours that are
/// whole bytes become bytes. Errors: BadOption, CannotEncode, OutOfMemory, Cancelled, DeadlineExceeded.
Result<Encoded> encode_as_draco(const MovedPositions& moved, std::span<const Triangle> triangles,
                                const SharedAttributes& attributes, const DracoOptions& options,
                                const RunControl& run);

}  // namespace burnish
