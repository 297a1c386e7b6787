// Private to the Draco codec: a check that Draco 1.5.5 leaves out between reading a count and believing it.
#pragma once

#include <draco/compression/attributes/attributes_decoder_interface.h>

#include <memory>

namespace burnish {

/// Takes the place of the attribute decoder that the library made for a mesh, which is then of no use. It
/// refuses texture predictions that claim more orientations than the mesh has corners: 261 bytes that claim
/// 2^31 of them keep the library busy for 6 s and take 256 MiB, for each attribute that says so. Null when
/// the library made something else than it does for meshes.
std::unique_ptr<draco::AttributesDecoderInterface> guarded(const draco::AttributesDecoderInterface* made);

}  // namespace burnish
