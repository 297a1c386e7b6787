// Private to the GLB codec: whether what smoothing changes is changed for one purpose only.
#pragma once

#include <functional>

#include "core/io/glb_document.h"

namespace burnish {

/// Interleaved rows may share a stretch of a buffer, rows of one kind may be cited by several accessors; but
/// positions must share no byte with normals, with indices (`read_only`), with compressed meshes, or with
/// positions that begin elsewhere. Calls same(a, b) for vertices whose stretches meet. Errors: MalformedMesh.
Result<> check_overlaps(const GlbDocument& document, std::span<const GlbAccessor> read_only,
                        const std::function<void(Index, Index)>& same);

}  // namespace burnish
