// CompareStream: two meshes of any size up, the error table down.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "server/grpc/call.h"

namespace burnish {

/// A reactor that deletes itself. `response` belongs to gRPC and lives as long as it.
grpc::ServerReadReactor<grpc::ByteBuffer>* compare_stream(CallHome& home,
                                                          grpc::CallbackServerContext& context,
                                                          grpc::ByteBuffer& response);

}  // namespace burnish
