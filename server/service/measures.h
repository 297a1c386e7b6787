// Core's measures in the contract's messages.
#pragma once

#include <string_view>

#include "burnish/v1/smoothing.pb.h"
#include "core/io/codec.h"
#include "core/measure/error.h"
#include "core/measure/quality.h"

namespace burnish {

void fill(const ErrorMeasures& measures, std::string_view against, v1::MeshErrors& out);
void fill(const MeshChange& change, v1::MeshChange& out);
void fill(const Encoded& encoded, Format format, v1::EncodingSummary& out);

/// The warning that normals could not be compared.
Warning connectivity_differs();

/// Whether both files have the same vertices in the same triangles, so that normals can be compared one by
/// one.
bool same_connectivity(const Document& a, const Document& b);

}  // namespace burnish
