// One attempt of a call by stream: the request goes up in chunks while the answer comes down.
#pragma once

#include <functional>

#include "burnish/v1/smoothing.grpc.pb.h"
#include "client/result.h"

namespace burnish::client {

inline constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

/// A file of more bytes fits into no `bytes` field that protobuf reads or writes.
inline constexpr std::size_t kLargestMeshBytes = 2'000'000'000;

using ProgressFunction = std::function<void(const v1::SmoothProgress&)>;

/// Calls `progress`, when there is one, on the calling thread. Errors: the server's; "internal" for an answer
/// without a report, "too_large" for one over kLargestMeshBytes. Throws what `progress` throws,
/// std::bad_alloc and std::system_error (no thread); the call is then cancelled.
Result<v1::SmoothResponse> smooth_by_stream(v1::SmoothingService::Stub& stub, grpc::ClientContext& context,
                                            const v1::SmoothRequest& request,
                                            const ProgressFunction& progress);

/// Errors: the server's. Throws std::bad_alloc.
Result<v1::CompareResponse> compare_by_stream(v1::SmoothingService::Stub& stub, grpc::ClientContext& context,
                                              const v1::CompareRequest& request);

}  // namespace burnish::client
