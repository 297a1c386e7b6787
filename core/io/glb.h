// glTF 2.0 binary (.glb): every triangle of every mesh, with KHR_draco_mesh_compression and
// KHR_mesh_quantization. Positions are those of the meshes' own spaces; nodes are not applied.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// Vertices are the rows of each POSITION accessor (or the points of each Draco bitstream) once, in the order
/// in which meshes and primitives cite them first. Errors: MalformedMesh, IndexOutOfRange, NonFinitePosition,
/// EmptyMesh, TooLarge, UnsupportedFormat, OutOfMemory, Cancelled, DeadlineExceeded; each names mesh and
/// primitive. `bytes` must outlive the Document.
Result<std::unique_ptr<Document>> decode_glb(std::string_view bytes, const Limits& limits,
                                             const RunControl& run);

/// Writes any mesh as a new GLB: one node, one mesh, one primitive with positions, unit normals, texture
/// coordinates (their second axis turned round, as glTF counts it from above) and colours. Vertices are split
/// at seams as encode_as_draco() does. Errors: CannotEncode, Cancelled, DeadlineExceeded.
Result<Encoded> encode_as_glb(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run);

}  // namespace burnish
