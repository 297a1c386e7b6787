// Private to the GLB codec: the vertices of a KHR_draco_mesh_compression, written anew.
#pragma once

#include "core/io/glb_document.h"

namespace burnish {

struct GlbCompressed {
  Encoded encoded;                        ///< as write_draco() gives it
  std::uint32_t points = 0, corners = 0;  ///< in the written bitstream
  Vec3d low, high;                        ///< of its positions
};

/// `normals` as GlbDocument::moved_normals() gives them. Where the file counts on the order of the points the
/// method is sequential. Errors: CannotEncode, BadOption, OutOfMemory, Cancelled, DeadlineExceeded.
Result<GlbCompressed> compress(const GlbDocument& document, Index vertices, const MovedPositions& moved,
                               const NormalRows& normals, const DracoOptions& options, const RunControl& run);

}  // namespace burnish
