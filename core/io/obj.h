// Wavefront OBJ. Reads `v`, `vt`, `vn` and `f`; carries every other line through untouched.
// Grammar: Appendix B1 of the Wavefront Advanced Visualizer manual; line continuations, negative indices,
// polygons and the common extension of colours after the coordinates (`v x y z r g b`) are understood.
#pragma once

#include "core/io/codec.h"

namespace burnish {

/// Errors: MalformedMesh, IndexOutOfRange, NonFinitePosition, EmptyMesh, TooLarge, Cancelled,
/// DeadlineExceeded; each names the line. `bytes` must outlive the Document. Files of more than `part_bytes`
/// are read in parts of about that size on run.threads; the outcome is the same.
Result<std::unique_ptr<Document>> decode_obj(std::string_view bytes, const Limits& limits,
                                             const RunControl& run,
                                             std::uint64_t part_bytes = std::uint64_t{1} << 20);

/// Writes any mesh as a new OBJ: `v` (with colours), `vt`, `vn`, `f`, in the order of the file it came from.
Result<Encoded> encode_as_obj(const MovedPositions& moved, std::span<const Triangle> triangles,
                              const SharedAttributes& attributes, const RunControl& run);

}  // namespace burnish
